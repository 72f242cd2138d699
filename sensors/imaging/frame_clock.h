// When a camera exposes, and which of its exposures is its image.
#pragma once

#include <cstdint>

namespace skybody::sensor {

/// Exposures at physics steps phase, phase + period, ...; each becomes the image `latency` steps
/// later. Before the first one the image shows the start of the episode.
struct FrameClock {
  std::int64_t period = 1;   ///< [physics steps], > 0
  std::int64_t phase = 0;    ///< [physics steps], < period
  std::int64_t latency = 0;  ///< [physics steps]

  /// Number of the exposure at a physics step; -1: there is none.
  std::int64_t exposure_at(std::int64_t step) const {
    const bool is_one = step >= phase && (step - phase) % period == 0;
    return is_one ? (step - phase) / period : -1;
  }
  /// Number of the exposure that becomes the image at a physics step; -1: the image stays.
  std::int64_t arrival_at(std::int64_t step) const { return exposure_at(step - latency); }
  /// Most exposures between their step and their arrival, both included.
  int most_kept() const { return static_cast<int>(latency / period) + 1; }
  /// Whether exposures and arrivals are at multiples of the period.
  bool is_regular() const { return phase == 0 && latency % period == 0; }
};

}  // namespace skybody::sensor
