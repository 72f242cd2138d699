// Messages between the driver of a PPO and its slices: plain numbers, which may be sent between
// machines. Their order is in docs/learners.md, Learning.
#pragma once

#include <cstdint>
#include <vector>

namespace skybody::learn {

/// Driver to slices, before a rollout, together with the networks' parameters.
struct RolloutInputs {
  std::int64_t iteration = 0;       ///< completed rollouts
  std::vector<double> mean, scale;  ///< normalization of the value function's inputs
  double return_mean = 0.0;         ///< of the discounted return
};

/// Slices to driver, after a rollout: an array of doubles. First these sums; then for each of the
/// value function's inputs the sum over rows of its difference from `mean`, and the sum of the
/// squared difference.
enum RolloutSum : int {
  kSumRows,
  kSumReturn,         ///< of the discounted return's difference from `return_mean`
  kSumReturnSquares,  ///< of the squared difference
  kSumError,          ///< distance from the goal [m]
  kSumErrorSteps,     ///< environment steps that reported this distance
  kSumFaults,
  kSumEnvironmentSeconds,  ///< time in the environments; for reports only
  kSumSeconds,             ///< of the whole rollout
  kRolloutSums
};

/// Slices to driver, after advantages: an array of doubles.
enum AdvantageSum : int {
  kSumAdvantage,
  kSumAdvantageSquares,
  kSumTarget,  ///< targets of the value function
  kSumTargetSquares,
  kAdvantageSums
};

/// Driver to slices, for each gradient step, together with the networks' parameters.
struct Minibatch {
  int epoch = 0;
  int index = 0;                     ///< within the epoch
  bool policy = true, value = true;  ///< gradients to compute
  double advantage_mean = 0.0, advantage_scale = 1.0;
};

/// Slices to driver, together with the gradients: an array of doubles, sums over the slice's rows.
enum MinibatchSum : int {
  kSumPolicyLoss,
  kSumKl,
  kSumClipped,    ///< rows
  kSumValueLoss,  ///< squared errors
  kMinibatchSums
};

}  // namespace skybody::learn
