// The driver of a PPO, one for all slices: parameters, their optimisers, statistics and schedules.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/files/policy_file.h"
#include "learn/common/running_moments.h"
#include "learn/common/state_blocks.h"
#include "learn/learner.h"
#include "learn/network/adam.h"
#include "learn/network/weight_average.h"
#include "learn/ppo/ppo_messages.h"
#include "learn/ppo/ppo_networks.h"
#include "learn/ppo/ppo_setup.h"

namespace skybody::learn {

/// Outputs of slices: one array per slice, in their order.
using SliceSums = std::span<const std::span<const double>>;
using SliceGradients = std::span<const float* const>;

/// PPO (Schulman et al. 2017, arXiv 1707.06347) with large batches, one pass of the policy over a
/// rollout and several of the value function. Order of calls, with the slices' work:
///
///   begin_rollout()      slices collect
///   take_rollout()       slices find advantages
///   take_advantages()
///   while next():        slices find gradients
///     step_policy(), step_value(), take_figures()
///   finish()             slices spread their starts
///
/// Outputs of slices are added in slice order, so that the result does not depend on where slices
/// run.
class PpoDriver {
 public:
  explicit PpoDriver(std::shared_ptr<const PpoSetup> setup);

  const PpoNetworks& networks() const { return networks_; }
  std::int64_t steps() const { return counters_.steps; }
  /// Completed rollouts.
  std::int64_t iteration() const { return counters_.iteration; }

  /// Limits the noise. @returns the inputs of slices, valid until the next call
  const RolloutInputs& begin_rollout();
  /// @param sums  indexed by RolloutSum
  /// @returns the factor on rewards
  double take_rollout(SliceSums sums);
  /// @param sums  indexed by AdvantageSum
  void take_advantages(SliceSums sums);

  /// The next gradient step. @returns false at the end of the update
  bool next(Minibatch& minibatch);
  /// One step of a network, if the minibatch is for the policy or for the value function. Both may
  /// run at the same time.
  /// @throws Diverged if the gradient is not finite
  void step_policy(SliceGradients gradients);
  void step_value(SliceGradients gradients);
  /// @param sums  indexed by MinibatchSum
  void take_figures(const Minibatch& minibatch, SliceSums sums);

  /// Ends the iteration: counts its steps, and adds its observations to the statistics.
  /// @throws Diverged if a parameter or a loss is not finite
  void finish();
  /// Report of the iteration that finish() has ended, without episodes' returns and seconds of the
  /// update.
  /// @param rollout_seconds  duration of the rollout
  Report report(double rollout_seconds) const;

  PolicyFile policy() const;
  std::uint64_t parameter_hash() const;

  void save(StateBlocks& blocks) const;
  /// @throws Error if `blocks` belong to another learner; nothing has then changed
  void check(const StateBlocks& blocks);
  void restore(const StateBlocks& blocks);

 private:
  struct Counters {
    std::int64_t steps = 0, iteration = 0;
  };
  /// Sums over an iteration.
  struct Figures {
    double policy_loss = 0.0, kl = 0.0, clipped = 0.0, policy_rows = 0.0;
    double value_loss = 0.0, value_rows = 0.0;
    double epoch_kl = 0.0, epoch_rows = 0.0;  ///< of the policy's current pass
  };

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor& visitor);
  double progress() const;
  void limit_noise();
  bool is_beyond_kl() const;
  void step(Adam& adam, std::span<float> parameters, SliceGradients gradients, double rate,
            const char* whose);
  void check_finite() const;
  [[noreturn]] void diverge(const std::string& what) const;

  std::shared_ptr<const PpoSetup> setup_;
  PpoNetworks networks_;
  Adam policy_adam_, value_adam_;
  RunningMoments moments_;         ///< of the value function's inputs
  RunningMoments return_moments_;  ///< of the discounted return
  WeightAverage average_;          ///< of the policy, over the last averaging_steps
  Counters counters_;

  // Of the current iteration:
  RolloutInputs inputs_;
  std::vector<double> rollout_, advantages_;  ///< sums over the slices
  Minibatch next_;
  bool policy_goes_on_ = true;
  Figures figures_;
};

}  // namespace skybody::learn
