#include "learn/network/moments.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/base/math.h"

namespace skybody::learn {

MomentSums::MomentSums(std::size_t columns) : center_(columns), sum_(columns), square_(columns) {}

void MomentSums::begin(const Moments& about) {
  std::copy(about.mean().begin(), about.mean().end(), center_.begin());
  std::fill(sum_.begin(), sum_.end(), 0.0);
  std::fill(square_.begin(), square_.end(), 0.0);
  count_ = 0.0;
}

void MomentSums::add(const float* rows, std::size_t stride, std::size_t count) {
  const std::size_t columns = sum_.size();
  const double* center = center_.data();
  double *sum = sum_.data(), *square = square_.data();
  for (std::size_t r = 0; r < count; ++r) {
    const float* row = rows + r * stride;
    for (std::size_t c = 0; c < columns; ++c) {
      const double off = static_cast<double>(row[c]) - center[c];
      sum[c] += off;
      square[c] += off * off;
    }
  }
  count_ += static_cast<double>(count);
}

Moments::Moments(std::size_t columns) : mean_(columns), square_(columns) {}

void Moments::merge(const MomentSums& sums) {
  if (sums.count_ == 0.0) return;
  const double total = count_ + sums.count_;
  for (std::size_t c = 0; c < mean_.size(); ++c) {
    const double off = sums.sum_[c] / sums.count_;  // of their mean from the center
    const double squares = std::max(0.0, sums.square_[c] - off * sums.sum_[c]);
    const double apart = sums.center_[c] + off - mean_[c];
    square_[c] += squares + apart * apart * (count_ * sums.count_ / total);
    mean_[c] += apart * (sums.count_ / total);
  }
  count_ = total;
}

double Moments::variance(std::size_t column) const {
  return count_ > 0.0 ? square_[column] / count_ : 0.0;
}

void Moments::scales(double epsilon, std::span<double> scales) const {
  for (std::size_t c = 0; c < mean_.size(); ++c) {
    scales[c] = count_ > 0.0 ? 1.0 / sqrt(variance(c) + epsilon) : 1.0;
  }
}

std::vector<double> Moments::state() const {
  std::vector<double> state = {count_};
  state.insert(state.end(), mean_.begin(), mean_.end());
  state.insert(state.end(), square_.begin(), square_.end());
  return state;
}

void Moments::restore(std::span<const double> state) {
  const std::size_t columns = mean_.size();
  if (state.size() != 1 + 2 * columns) {
    throw Error("running moments of a checkpoint have " + std::to_string(state.size()) +
                " values; needed: " + std::to_string(1 + 2 * columns));
  }
  count_ = state[0];
  std::copy_n(state.data() + 1, columns, mean_.data());
  std::copy_n(state.data() + 1 + columns, columns, square_.data());
}

}  // namespace skybody::learn
