// Messages between the driver of a PPO and its slices: plain numbers, which may cross from
// one machine to another. docs/architecture.md, Learning, has the order.
#pragma once

#include <cstdint>
#include <vector>

namespace skybody::learn {

/// Driver to slices, before a rollout, beside the networks' parameters.
struct RolloutInputs {
  std::int64_t iteration = 0;       ///< rollouts done before this one
  std::vector<double> mean, scale;  ///< of the value function's inputs, for their normalization
  double return_mean = 0.0;         ///< of the discounted return
};

/// Slices to driver, after a rollout: an array of doubles, these first, then for each of the value
/// function's inputs the sum over rows of its difference from `mean`, then of the square of that.
enum RolloutSum : int {
  kSumRows,
  kSumReturn,         ///< of the discounted return's difference from `return_mean`
  kSumReturnSquares,  ///< of the square of that
  kSumError,          ///< distance from the goal [m]
  kSumErrorSteps,     ///< environment steps that gave one
  kSumFaults,
  kSumEnvironmentSeconds,  ///< in the environments; figures alone, no bits follow from them
  kSumSeconds,             ///< of the whole rollout
  kRolloutSums
};

/// Slices to driver, after advantages: an array of doubles.
enum AdvantageSum : int {
  kSumAdvantage,
  kSumAdvantageSquares,
  kSumTarget,  ///< what the value function is fitted to
  kSumTargetSquares,
  kAdvantageSums
};

/// Driver to slices, for each gradient step, beside the networks' parameters.
struct Minibatch {
  int epoch = 0;
  int index = 0;                     ///< of the epoch
  bool policy = true, value = true;  ///< whose gradients are wanted
  double advantage_mean = 0.0, advantage_scale = 1.0;
};

/// Slices to driver, beside the gradients: an array of doubles, sums over the slice's rows.
enum MinibatchSum : int {
  kSumPolicyLoss,
  kSumKl,
  kSumClipped,    ///< rows
  kSumValueLoss,  ///< squared errors
  kMinibatchSums
};

}  // namespace skybody::learn
