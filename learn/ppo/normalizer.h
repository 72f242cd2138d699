// Observations as networks see them, and the sums that running statistics are made of.
#pragma once

#include <span>

#include "core/base/isa.h"

namespace skybody::learn {

/// Sums over rows, of what each column differs from its mean so far.
struct ColumnSums {
  double* sum;      ///< one a column
  double* squares;  ///< likewise
};

/// Normalizes rows where they lie: x becomes clip((x - mean) scale, -bound, bound), in double, then
/// rounded, as a policy file says.
class Normalizer {
 public:
  /// @param bound  of the normalized values
  Normalizer(double bound, Isa isa) : bound_(bound), isa_(isa) {}

  /// @param rows         row r at rows + r * stride, mean.size() wide
  /// @param mean, scale  one a column
  /// @param sums         null, or where x - mean and its square are added for every row
  void apply(float* rows, int count, int stride, std::span<const double> mean,
             std::span<const double> scale, const ColumnSums* sums) const;

 private:
  double bound_;
  Isa isa_;
};

}  // namespace skybody::learn
