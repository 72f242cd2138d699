// Value of the states after a horizon: a function of observations, learned from the horizons
// themselves.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "learn/hyperparameters.h"
#include "learn/network/trained_network.h"

namespace skybody::learn {

/// TD(lambda) targets of a sequence of transitions (Sutton and Barto 2018, section 12.2), as in the
/// critic of Xu et al. 2022 (arXiv 2204.07137, eq. 6 and 7):
///
///   target_t = gain_t + discount ((1 - lambda) value_t + lambda target_(t+1)),
///
/// where value_t is the value of the state after transition t, and the target after the last
/// transition is its value.
/// @param gains, values  one per transition   @param targets  one per transition, output
void td_lambda(std::span<const double> gains, std::span<const double> values, double discount,
               double lambda, std::span<double> targets);

/// A critic and its delayed copy. The copy gives the targets and the slope at a horizon's end
/// (arXiv 2204.07137, section 3.2). The network's output is (1 - discount) times the value: about
/// the gain of one transition, whatever the discount.
class ValueFunction {
 public:
  ValueFunction(int observed, const Hyperparameters& hyper, std::uint64_t seed);

  const Network& network() const { return critic_.network(); }
  std::span<const float> parameters() const { return critic_.parameters(); }
  std::span<const float> target_parameters() const { return {delayed_.data(), delayed_.size()}; }
  const TransposedWeights& transposed() const { return critic_.transposed(); }
  const TransposedWeights& delayed_transposed() const { return delayed_transposed_; }
  /// Factor from the network's output to the value.
  double scale() const { return scale_; }
  static double scale_of(const Hyperparameters& hyper);

  /// One optimiser step. @returns the gradient's norm @param gradients  of the slices
  double step(std::span<const float* const> gradients, double learning_rate) {
    return critic_.step(gradients, learning_rate);
  }
  /// Moves the delayed copy towards the critic. Called once per iteration, after all steps.
  void follow();

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h), and prepares computations with
  /// the values that it has written. @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    TrainedNetwork::visit(self.critic_, name, visitor);
    visitor(name + ".delayed", self.delayed_.data(), self.delayed_.size());
    if constexpr (!std::is_const_v<Self>) self.prepare();
  }

 private:
  void prepare();

  TrainedNetwork critic_;
  AlignedArray<float> delayed_;
  TransposedWeights delayed_transposed_;
  double scale_;
};

}  // namespace skybody::learn
