#include "learn/network/weight_average.h"

#include <algorithm>

namespace skybody::learn {

void WeightAverage::add(std::span<const float> weights, double steps) {
  if (values_.empty()) return;
  ++count_;
  // The first updates have equal weights, so that the average starts as a plain mean.
  const double share = std::max(1.0 / static_cast<double>(count_), std::min(1.0, steps / steps_));
  for (std::size_t k = 0; k < values_.size(); ++k) {
    values_[k] += share * (static_cast<double>(weights[k]) - values_[k]);
  }
}

std::vector<float> WeightAverage::of(std::span<const float> weights) const {
  if (count_ == 0) return {weights.begin(), weights.end()};
  return {values_.begin(), values_.end()};
}

}  // namespace skybody::learn
