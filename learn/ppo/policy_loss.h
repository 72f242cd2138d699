// PPO's clipped surrogate (Schulman et al. 2017, arXiv 1707.06347, eq. 7) of some rows, and its
// gradient at the network's outputs.
#pragma once

#include <span>
#include <vector>

#include "core/base/simd/isa.h"
#include "learn/common/gaussian.h"

namespace skybody::learn {

/// Sums over rows, for reports.
struct PolicyFigures {
  double loss = 0.0;  ///< -min(ratio advantage, clipped ratio advantage)
  double kl = 0.0;  ///< ratio - 1 - ln ratio: estimates the KL divergence from the policy that drew
                    ///< the actions (Schulman, "Approximating KL divergence", 2020, k3)
  double clipped = 0.0;  ///< rows whose ratio is outside the range
};

/// Rows of a rollout, and the network's current outputs for them.
struct PolicyRows {
  int count = 0;
  const float* action = nullptr;  ///< row r at action + r * stride
  const float* log_probability =
      nullptr;  ///< at the time of the draw; row r at log_probability + r * stride
  const float* advantage = nullptr;  ///< not yet normalized; row r at advantage + r * stride
  int stride = 0;
  const float* mean = nullptr;  ///< of the current distribution, count x actions
};

/// Inputs of the loss.
struct PolicyLossTerms {
  double clip_range = 0.2;
  double advantage_mean = 0.0, advantage_scale = 1.0;  ///< the loss uses (advantage - mean) scale
  double weight = 1.0;      ///< weight of a row: 1 / rows of the minibatch
  bool is_bounded = false;  ///< means are tanh of the network's outputs
};

/// Processes at most `most_rows` rows per call.
class PolicyLoss {
 public:
  PolicyLoss(int most_rows, Isa isa);

  /// @param gradient          of the weighted loss at the network's outputs, count x actions,
  ///        overwritten
  /// @param log_std_gradient  of the weighted loss at the logarithms of deviations; added to
  /// @param figures           added to
  void apply(const PolicyRows& rows, const Deviations& deviations, const PolicyLossTerms& terms,
             float* gradient, std::span<double> log_std_gradient, PolicyFigures& figures);

 private:
  Isa isa_;
  std::vector<double> log_ratio_, ratio_;  ///< of each row; whole packs
};

}  // namespace skybody::learn
