// Far surfaces fade into the colour of the horizon.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "render/scene.h"

namespace skybody::render {

/// The share of the horizon in a colour grows with the depth d of the surface: d^2 / (d^2 +
/// half^2), in steps of 1/256. The sky stays.
class Haze {
 public:
  /// @param half      depth of equal shares [m]; 0: no haze
  /// @param farthest  depth of the sky [m]
  Haze(const Color& horizon, float half, float farthest)
      : half_square_(half * half), farthest_(farthest) {
    for (std::size_t i = 0; i < 3 * kRun; ++i) {
      color_[i] = static_cast<std::int16_t>(255.0f * horizon[i % 3] + 0.5f);
    }
  }

  bool is_none() const { return half_square_ == 0.0f; }

  /// Fades some pixels.
  void fade(const float* depth, std::ptrdiff_t count, std::uint8_t* rgb) const {
    if (is_none()) return;
    for (; count >= kRun; count -= kRun, depth += kRun, rgb += 3 * kRun) fade_run(depth, kRun, rgb);
    if (count > 0) fade_run(depth, static_cast<int>(count), rgb);
  }

 private:
  static constexpr int kRun = 16;

  /// In 1/256.
  int share(float depth) const {
    const float square = depth * depth;
    const float share = 256.0f * square / (square + half_square_);
    return depth < farthest_ ? static_cast<int>(share) : 0;
  }

  void fade_run(const float* depth, int count, std::uint8_t* rgb) const {
    std::int16_t shares[kRun] = {};
    int most = 0;
    for (int i = 0; i < count; ++i) {
      shares[i] = static_cast<std::int16_t>(share(depth[i]));
      most = std::max<int>(most, shares[i]);
    }
    if (most == 0) return;
    std::int16_t spread[3 * kRun];
    for (int i = 0; i < kRun; ++i) {
      spread[3 * i] = spread[3 * i + 1] = spread[3 * i + 2] = shares[i];
    }
    for (int i = 0; i < 3 * count; ++i) {
      const int change = (color_[i] - rgb[i]) * spread[i];
      rgb[i] = static_cast<std::uint8_t>(rgb[i] + ((change + 128) >> 8));
    }
  }

  float half_square_, farthest_;
  std::int16_t color_[3 * kRun];
};

}  // namespace skybody::render
