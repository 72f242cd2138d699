#include "learn/common/running_normalizer.h"

#include <algorithm>

namespace skybody::learn {

RunningNormalizer::RunningNormalizer(std::size_t columns, double bound, Isa isa)
    : bound_(bound),
      normalizer_(bound, isa),
      moments_(columns),
      scale_(columns),
      sum_(columns),
      squares_(columns) {
  update();
}

void RunningNormalizer::apply(float* rows, int count, int stride, bool counts) {
  const ColumnSums sums{sum_.data(), squares_.data()};
  normalizer_.apply(rows, count, stride, moments_.mean, scale_, counts ? &sums : nullptr);
  if (counts) rows_ += count;
}

void RunningNormalizer::update() {
  moments_.add(rows_, sum_, squares_);
  for (std::size_t k = 0; k < scale_.size(); ++k) scale_[k] = moments_.scale(k);
  std::fill(sum_.begin(), sum_.end(), 0.0);
  std::fill(squares_.begin(), squares_.end(), 0.0);
  rows_ = 0.0;
}

}  // namespace skybody::learn
