// Running means and variances of columns, in double.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace skybody::learn {

class Moments;

/// Sums over some rows, about a point near their mean. Those of several slices are added to Moments
/// one after another, in a fixed order.
class MomentSums {
 public:
  explicit MomentSums(std::size_t columns);

  /// Begins anew. Sums are taken about the mean so far, so that squares do not cancel.
  void begin(const Moments& about);
  /// @param rows  row r at rows + r * stride, `columns` wide; all finite
  void add(const float* rows, std::size_t stride, std::size_t count);

 private:
  friend class Moments;
  std::vector<double> center_, sum_, square_;
  double count_ = 0.0;
};

/// Count, mean and sum of squared deviations of each column, which sums of further rows are merged
/// into (Chan, Golub and LeVeque, "Updating formulae and a pairwise algorithm for computing sample
/// variances", 1979, eq. 2.1).
class Moments {
 public:
  explicit Moments(std::size_t columns);

  void merge(const MomentSums& sums);

  double count() const { return count_; }
  std::span<const double> mean() const { return mean_; }
  /// Of the population: 0 before the first row.
  double variance(std::size_t column) const;
  /// 1 / sqrt(variance + epsilon), of each column; 1 before the first row.
  void scales(double epsilon, std::span<double> scales) const;

  /// What a checkpoint holds: count, means, sums of squared deviations.
  std::vector<double> state() const;
  /// @throws Error if the state has another number of columns
  void restore(std::span<const double> state);

 private:
  double count_ = 0.0;
  std::vector<double> mean_, square_;
};

}  // namespace skybody::learn
