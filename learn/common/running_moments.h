// Running mean and variance of columns.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace skybody::learn {

/// Mean and variance of all rows so far, by the update of Chan, Golub and LeVeque (1979, "Updating
/// formulae and a pairwise algorithm for computing sample variances", eq. 2.1). Without rows: mean
/// 0, variance 1.
struct RunningMoments {
  std::vector<double> mean, variance;
  double count = 0.0;

  explicit RunningMoments(std::size_t columns) : mean(columns, 0.0), variance(columns, 1.0) {}

  /// Adds `rows` rows.
  /// @param sum, squares  of each column's difference from the current `mean`
  void add(double rows, std::span<const double> sum, std::span<const double> squares);
  /// 1 / sqrt(variance + 1e-8) of a column.
  double scale(std::size_t column) const;

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h). @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".mean", self.mean.data(), self.mean.size());
    visitor(name + ".variance", self.variance.data(), self.variance.size());
    visitor(name + ".count", &self.count, 1);
  }
};

/// The moments of some values, of one column.
RunningMoments moments_of(std::span<const float> values);

}  // namespace skybody::learn
