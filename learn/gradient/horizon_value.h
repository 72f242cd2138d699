// A slice's evaluations of the value function, and its training data for it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "learn/gradient/value_function.h"

namespace skybody::learn {

/// A group's horizon, in lanes of kGroupLanes: the source of the value function's rows.
struct HorizonRows {
  int steps;
  int stride;                ///< stride of rows of observations
  const float* observation;  ///< normalised, before each transition: row t * kGroupLanes + lane
  const float* end;          ///< normalised, after each lane's last transition: row lane
  const double* gain;        ///< of each transition: t * kGroupLanes + lane
  std::span<const std::uint32_t> taken;  ///< per transition: lanes that took it without a fault
  std::uint32_t worthless;               ///< lanes whose episode has terminated
};

/// Rows of one slice's horizons of an iteration.
class HorizonValue {
 public:
  /// @param weight     of a row in the loss: half the squared error of the network's output
  /// @param most_rows  transitions of an iteration
  HorizonValue(const ValueFunction& value, const Hyperparameters& hyper, int stride, double weight,
               int most_rows);

  /// Removes the rows of the previous iteration.
  void clear() { count_ = 0; }
  /// Slope of the delayed value by the normalised observation, at each lane's end.
  /// @returns kGroupLanes rows, valid until the next call
  const float* slopes(const float* end);
  /// Adds a group's transitions with their targets.
  void add(const HorizonRows& rows);

  /// Computes the gradient of the loss over all rows at the critic's current parameters.
  void find_gradient();
  std::span<const float> gradient() const { return {gradient_.data(), gradient_.size()}; }
  /// Loss at the last find_gradient().
  double loss() const { return loss_; }

 private:
  void evaluate(const float* rows, int count, double* values);
  void add_lane(const HorizonRows& rows, int lane);

  const ValueFunction& value_;
  int stride_, count_ = 0;
  double discount_, lambda_, weight_;
  NetworkActivations memory_;
  AlignedArray<float> rows_, targets_;  ///< of the current iteration
  AlignedArray<float> gradient_, unused_gradient_, slopes_, output_, error_;
  std::vector<double> before_, after_end_;                    ///< delayed values of a group's rows
  std::vector<double> lane_gain_, lane_value_, lane_target_;  ///< of one lane's transitions
  double loss_ = 0.0;
};

}  // namespace skybody::learn
