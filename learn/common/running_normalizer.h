// Normalization of rows by their own running mean and deviation.
#pragma once

#include <span>
#include <vector>

#include "learn/common/normalizer.h"
#include "learn/common/running_moments.h"

namespace skybody::learn {

/// Rows are normalized by the moments of the rows before the last update(), so that all rows of a
/// rollout have one scale.
class RunningNormalizer {
 public:
  /// @param columns  values of a row
  /// @param bound    of the normalized values
  explicit RunningNormalizer(std::size_t columns, double bound = 10.0, Isa isa = best_isa());

  /// Normalizes rows in place.
  /// @param rows    row r at rows + r * stride
  /// @param counts  whether these rows count in the next update()
  void apply(float* rows, int count, int stride, bool counts);
  /// Adds the counted rows to the moments.
  void update();

  /// Mean and variance of each column, unit of the column and its square.
  const RunningMoments& moments() const { return moments_; }
  /// Factor of each column: 1 / sqrt(variance + 1e-8).
  std::span<const double> scale() const { return scale_; }
  double bound() const { return bound_; }

 private:
  double bound_;
  Normalizer normalizer_;
  RunningMoments moments_;
  std::vector<double> scale_, sum_, squares_;
  double rows_ = 0.0;  ///< counted since the last update()
};

}  // namespace skybody::learn
