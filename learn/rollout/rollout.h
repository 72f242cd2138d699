// A rollout of all environments, for algorithms of one's own: observations, actions, advantages.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/io/files/policy_file.h"
#include "learn/common/running_moments.h"
#include "learn/common/running_normalizer.h"
#include "learn/network/trained_network.h"
#include "learn/position_error.h"
#include "learn/rollout/advantage_estimator.h"
#include "learn/rollout/discounted_returns.h"
#include "learn/rollout/rollout_environments.h"

namespace skybody::learn {

/// Arguments of a Rollout.
struct RolloutOptions {
  std::shared_ptr<const CompiledScenario> compiled;
  int envs = 256;            ///< number of environments
  int steps = 32;            ///< of each environment in a rollout
  std::uint64_t seed = 0;    ///< of the environments' random numbers
  int threads = 0;           ///< including the caller; 0: one per processor. Changes no result
  double discount = 0.99;    ///< gamma, 0 ... 1
  double gae_lambda = 0.95;  ///< lambda of generalized advantage estimation, 0 ... 1
  double observation_clip = 10.0;    ///< bound of normalized observations
  double normalization_steps = 0.0;  ///< environment steps after which the statistics of
                                     ///< observations are frozen; 0: never
};

/// `steps` steps of `envs` environments. Row step * envs + env is a transition of an environment.
/// Observations are normalized by the mean and deviation of all earlier rollouts, rewards are
/// divided by the deviation of the discounted return. Vectors only: no images, no privileged rows.
class Rollout {
 public:
  /// Begins episodes in all environments.
  /// @throws Error if an option is out of range, or the scenario has neither observation nor action
  explicit Rollout(const RolloutOptions& options);

  int envs() const { return environments_.size(); }
  int rows() const { return advantages_.steps() * envs(); }
  /// Floats from one row of observations to the next.
  int stride() const { return stride_; }
  /// Environment steps so far, over all rollouts.
  std::int64_t total_steps() const { return total_steps_; }

  /// Runs the steps of a rollout.
  /// @param choose  choose(step, x, actions): writes the actions of all environments, envs() rows
  ///        of action_size() values. Row e of their observations is at x + e * stride()
  /// @throws an exception of a plugin or of `choose`
  template <class Choose>
  void collect(const Choose& choose) {
    begin();
    for (int step = 0; step < advantages_.steps(); ++step) {
      observe(step);
      choose(step, observations(step), actions_of(step));
      act(step);
    }
    finish();
  }
  /// Estimates the advantages of the rollout, and the targets of the value function, both in units
  /// of the scaled rewards.
  /// @param value  value(x, rows, y): writes the values of `rows` observations, row r at
  ///        x + r * stride(), to y[r]
  template <class Value>
  void find_advantages(const Value& value) {
    value(observations(0), rows() + envs(), advantages_.values().data());
    if (!cut_.empty()) value(last_.data(), static_cast<int>(cut_.size()), last_values_.data());
    estimate();
  }

  /// Normalized observations from a step on. Those after the last step follow at step `steps`.
  const float* observations(int step = 0) const {
    return rows_.data() + static_cast<std::ptrdiff_t>(advantages_.at(step, 0)) * stride_;
  }
  /// As `choose` wrote them: rows() x action_size().
  std::span<const float> actions() const { return actions_; }
  std::span<const float> advantages() const { return advantage_; }  ///< of each row
  std::span<const float> targets() const { return target_; }        ///< likewise: advantage + value
  /// As the task gave them, not scaled.
  std::span<const float> rewards() const { return advantages_.rewards(); }
  /// Sums of rewards of the episodes that ended in this rollout.
  std::span<const float> episode_returns() const { return episode_returns_; }

  /// Distance from the task's goal, mean over the rollout [m]; NaN if the task does not report it.
  double position_error() const { return error_sum_ / error_count_; }

  /// The deterministic policy of a network, with this normalization, for write_policy().
  /// @param algorithm  name of the algorithm, for the file
  PolicyFile policy(const TrainedNetwork& network, const std::string& algorithm) const;
  /// Statistics of the observations.
  const RunningNormalizer& normalizer() const { return normalizer_; }
  /// The environments, such as for infos of the last step.
  const RolloutEnvironments& environments() const { return environments_; }

 private:
  void begin();
  void observe(int step);
  std::span<float> actions_of(int step);
  void act(int step);
  void finish();
  void estimate();
  void add_error(int env, bool has_ended);

  int stride_;
  AdvantageTerms terms_;
  double normalization_steps_;
  RolloutEnvironments environments_;
  RunningNormalizer normalizer_;
  DiscountedReturns discounted_;
  RunningMoments return_moments_;
  AdvantageEstimator advantages_;
  AlignedArray<float> rows_;      ///< observations
  AlignedArray<float> last_;      ///< last observations of truncated episodes
  std::vector<std::size_t> cut_;  ///< their transitions
  std::vector<float> last_values_, actions_, advantage_, target_, episode_returns_;
  std::vector<double> returns_;  ///< of the running episodes
  std::int64_t total_steps_ = 0;
  PositionError error_;
  double error_sum_ = 0.0, error_count_ = 0.0;
};

}  // namespace skybody::learn
