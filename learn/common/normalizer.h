// Normalizes observations for the networks, and sums them for running statistics.
#pragma once

#include <span>

#include "core/base/simd/isa.h"

namespace skybody::learn {

/// Sums over rows of each column's difference from its running mean.
struct ColumnSums {
  double* sum;      ///< one per column
  double* squares;  ///< sum of squares, one per column
};

/// Normalizes rows in place: x becomes clip((x - mean) scale, -bound, bound), in double, then
/// rounded, as specified for policy files.
class Normalizer {
 public:
  /// @param bound  of the normalized values
  Normalizer(double bound, Isa isa) : bound_(bound), isa_(isa) {}

  /// @param rows         row r at rows + r * stride, mean.size() wide
  /// @param mean, scale  one per column
  /// @param sums         null, or sums to which x - mean and its square are added for every row
  void apply(float* rows, int count, int stride, std::span<const double> mean,
             std::span<const double> scale, const ColumnSums* sums) const;

 private:
  double bound_;
  Isa isa_;
};

}  // namespace skybody::learn
