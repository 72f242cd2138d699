// A histogram of times, with quantiles.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace skybody::onboard {

/// Counts times in ns. Bounds of neighbouring bins differ by 3 %. Does not allocate.
class LatencyHistogram {
 public:
  void add(std::int64_t nanoseconds);
  std::uint64_t count() const { return count_; }
  /// The time that a share of all does not exceed, to 3 % [ns]; the largest one is exact.
  std::int64_t quantile(double share) const;
  std::int64_t largest() const { return largest_; }
  /// Number of times above a bound, to 3 % of it.
  std::uint64_t above(std::int64_t nanoseconds) const;
  /// An object of JSON: count, p50, p99, p99.9 and max in microseconds.
  std::string json() const;
  /// One line with the same.
  std::string text() const;

 private:
  static constexpr int kSteps = 32;  // bins between powers of two
  static std::size_t bin_of(std::int64_t nanoseconds);
  static std::int64_t upper_bound(std::size_t bin);

  std::array<std::uint64_t, 64 * kSteps> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t largest_ = 0;
};

}  // namespace skybody::onboard
