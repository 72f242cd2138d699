#include "learn/common/running_moments.h"

#include <algorithm>
#include <cmath>

namespace skybody::learn {

void RunningMoments::add(double rows, std::span<const double> sum,
                         std::span<const double> squares) {
  if (rows <= 0.0) return;
  const double total = count + rows;
  for (std::size_t k = 0; k < mean.size(); ++k) {
    const double delta = sum[k] / rows;
    // Round-off can make the variance of a nearly constant column negative; clamp it.
    const double spread = std::max(squares[k] / rows - delta * delta, 0.0);
    variance[k] =
        (count * variance[k] + rows * spread + delta * delta * (count * rows / total)) / total;
    mean[k] += delta * (rows / total);
  }
  count = total;
}

double RunningMoments::scale(std::size_t column) const {
  constexpr double kLeastVariance = 1e-8;
  return 1.0 / std::sqrt(variance[column] + kLeastVariance);
}

RunningMoments moments_of(std::span<const float> values) {
  double sum = 0.0, squares = 0.0;
  for (const float value : values) {
    const double x = static_cast<double>(value);
    sum += x;
    squares += x * x;
  }
  RunningMoments moments(1);
  moments.add(static_cast<double>(values.size()), {&sum, 1}, {&squares, 1});
  return moments;
}

}  // namespace skybody::learn
