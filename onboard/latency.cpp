#include "onboard/latency.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace skybody::onboard {

std::size_t LatencyHistogram::bin_of(std::int64_t nanoseconds) {
  const auto value = static_cast<std::uint64_t>(nanoseconds);
  if (value < kSteps) return value;
  const int shift = std::bit_width(value) - 6;  // leaves the five bits below the highest
  return static_cast<std::size_t>(shift + 1) * kSteps + (value >> shift) % kSteps;
}

std::int64_t LatencyHistogram::upper_bound(std::size_t bin) {
  if (bin < kSteps) return static_cast<std::int64_t>(bin);
  const std::size_t shift = bin / kSteps - 1;
  const std::uint64_t top = kSteps + bin % kSteps;
  return static_cast<std::int64_t>(((top + 1) << shift) - 1);
}

void LatencyHistogram::add(std::int64_t nanoseconds) {
  const std::int64_t value = std::max<std::int64_t>(0, nanoseconds);
  ++bins_[std::min(bin_of(value), bins_.size() - 1)];
  ++count_;
  largest_ = std::max(largest_, value);
}

std::int64_t LatencyHistogram::quantile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t sum = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    sum += bins_[bin];
    if (sum >= wanted && sum > 0) return std::min(upper_bound(bin), largest_);
  }
  return largest_;
}

std::uint64_t LatencyHistogram::above(std::int64_t nanoseconds) const {
  std::uint64_t sum = 0;
  for (std::size_t bin = bin_of(nanoseconds) + 1; bin < bins_.size(); ++bin) sum += bins_[bin];
  return sum;
}

std::string LatencyHistogram::json() const {
  char text[256];
  const auto micros = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
  std::snprintf(text, sizeof text,
                "{\"count\": %llu, \"p50_us\": %.1f, \"p99_us\": %.1f, \"p99_9_us\": %.1f, "
                "\"max_us\": %.1f, \"above_1_ms\": %llu}",
                static_cast<unsigned long long>(count_), micros(quantile(0.5)),
                micros(quantile(0.99)), micros(quantile(0.999)), micros(largest_),
                static_cast<unsigned long long>(above(1'000'000)));
  return text;
}

std::string LatencyHistogram::text() const {
  char line[160];
  const auto micros = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
  std::snprintf(line, sizeof line, "p50 %.1f  p99 %.1f  p99.9 %.1f  max %.1f us",
                micros(quantile(0.5)), micros(quantile(0.99)), micros(quantile(0.999)),
                micros(largest_));
  return line;
}

}  // namespace skybody::onboard
