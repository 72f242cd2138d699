// Some environments of a PPO with their rollout: the unit of work of one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "learn/common/gaussian.h"
#include "learn/common/normalizer.h"
#include "learn/common/state_blocks.h"
#include "learn/ppo/minibatch_order.h"
#include "learn/ppo/policy_loss.h"
#include "learn/ppo/ppo_messages.h"
#include "learn/ppo/ppo_networks.h"
#include "learn/ppo/ppo_setup.h"
#include "learn/ppo/rollout_images.h"
#include "learn/ppo/slice_memory.h"
#include "learn/rollout/advantage_estimator.h"
#include "learn/rollout/discounted_returns.h"
#include "learn/rollout/rollout_environments.h"

namespace skybody::learn {

/// Scratch memory of a thread, for any slice.
struct SliceScratch {
  explicit SliceScratch(const PpoSetup& setup);

  static constexpr int kRows = 128;  ///< rows per pass through a network
  int minibatch_rows;  ///< rows per pass of a minibatch; larger for a policy with a memory, whose
                       ///< sequences stay whole; smaller with images, which then stay in the cache
  PolicyNetwork::Memory policy, value;
  AlignedArray<float> rows;              ///< of a minibatch, gathered
  AlignedArray<float> output, gradient;  ///< of either network, for these rows
  std::vector<std::uint8_t> begins;      ///< for the gathered rows of a policy with a memory
  AlignedArray<float> states;  ///< before the gathered sequences of a policy with a memory
  PolicyLoss loss;
};

/// Slice `index` of the plan. No work is pending between two calls of the driver.
///
/// Rows of a step are the slice's environments, or their robots, environment by environment. All
/// its random numbers follow from the seed, its rows and the iteration.
class PpoSlice {
 public:
  PpoSlice(std::shared_ptr<const PpoSetup> setup, int index);

  /// Runs a rollout: fills the rows and the sums.
  void collect(const RolloutInputs& inputs, const PpoNetworks& networks, SliceScratch& scratch);
  /// Computes values of the rollout's observations, then generalized advantage estimation (Schulman
  /// et al. 2016, arXiv 1506.02438, eq. 16) for rewards times `reward_scale`.
  void find_advantages(double reward_scale, const PpoNetworks& networks, SliceScratch& scratch);
  /// Computes the gradients of the slice's share of a minibatch, as parts of the minibatch's mean
  /// loss.
  void find_gradients(const Minibatch& minibatch, const PpoNetworks& networks,
                      SliceScratch& scratch);
  /// Resets the k-th of horizon / rollout_steps groups of environments after rollout k, so that
  /// later rollouts sample all parts of an episode.
  /// @param iteration  completed rollouts
  void stagger_resets(std::int64_t iteration);

  std::span<const double> rollout_sums() const { return rollout_sums_; }
  std::span<const double> advantage_sums() const { return advantage_sums_; }
  std::span<const double> minibatch_sums() const { return gradients_.sums; }
  /// In the layout of PpoNetworks::policy_parameters().
  std::span<const float> policy_gradient() const {
    return {gradients_.policy.data(), gradients_.policy.size()};
  }
  std::span<const float> value_gradient() const {
    return {gradients_.value.data(), gradients_.value.size()};
  }
  /// Returns of the episodes that ended in the rollout.
  std::span<const float> episode_returns() const { return episode_returns_; }

  /// The last rollout, for tests of the training data. Row r of step t is row t * rows_of_step + r.
  /// `value` and `rows` also contain the last observations, after the last step.
  struct LastRollout {
    int steps, rows_of_step;
    std::span<const float> rows;  ///< RowLayout; the rows after the last step have inputs only
    std::span<const float> reward, goes_on, bootstrap, value;
    std::span<const int> order;  ///< of the last epoch
  };
  LastRollout rollout() const {
    return {steps_,
            step_rows_,
            {rows_.data(), rows_.size()},
            advantages_.rewards(),
            advantages_.goes_on(),
            advantages_.end_values(),
            advantages_.values(),
            order_.order()};
  }

  /// Passes the checkpointed arrays, without the environments, to `visitor`.
  template <class Self, class Visitor>
  static void visit(Self& self, Visitor& visitor) {
    const std::string name = "slice" + std::to_string(self.index_);
    DiscountedReturns::visit(self.discounted_, name + ".discounted", visitor);
    visitor(name + ".returns", self.returns_.data(), self.returns_.size());
    SliceMemory::visit(self.memory_, name, visitor);
  }
  std::vector<std::uint64_t> save_environments() const { return environments_.save(); }
  void restore_environments(std::span<const std::uint64_t> words);

 private:
  float* row(int step, int row_of_step) {
    return rows_.data() + at(step, row_of_step) * static_cast<std::size_t>(stride_);
  }
  std::size_t at(int step, int row_of_step) const { return advantages_.at(step, row_of_step); }
  void clear_sums();
  void copy_inputs(const float* observation, const float* privileged, float* first);
  void write_inputs(int step, bool adds_sums);
  PolicySteps recall(int step, int first, int count);
  void choose_actions(int step, const PpoNetworks& networks, SliceScratch& scratch);
  void command(int step);
  void step_environments();
  void take_outcome(int step);
  void take_rewards(int step, int env);
  void end_episode(int step, int env, EpisodeEnd end);
  void value_cut_episodes(const PpoNetworks& networks, SliceScratch& scratch);
  void find_values(const PpoNetworks& networks, SliceScratch& scratch);
  void gather(int first, int count, SliceScratch& scratch);
  PolicySteps gathered_steps(int first, int count, SliceScratch& scratch) const;
  void add_policy_gradient(const Minibatch&, const PolicySteps&, const PpoNetworks&, SliceScratch&);
  void add_value_gradient(const Minibatch&, const PolicySteps&, const PpoNetworks&, SliceScratch&);

  /// A step's draws: normals and means of its rows, actions of its environments.
  struct Draws {
    std::vector<float> noise, mean, action;
  };
  /// Episodes that a step truncated: the rows of their last inputs, and their transitions.
  struct CutEpisodes {
    AlignedArray<float> inputs;
    std::vector<std::size_t> at;
  };
  /// Results of a minibatch.
  struct Gradients {
    std::vector<double> sums, log_std;
    AlignedArray<float> policy, value;
  };

  std::shared_ptr<const PpoSetup> setup_;
  int index_, step_rows_, steps_, stride_;
  Normalizer normalizer_;
  RolloutEnvironments environments_;
  const RolloutInputs* inputs_ = nullptr;  ///< of the current rollout
  std::int64_t iteration_ = 0;             ///< of the last rollout
  Deviations deviations_;

  AlignedArray<float> rows_;  ///< steps + 1 times step_rows_; RowLayout
  AdvantageEstimator advantages_;
  Draws draws_;
  RolloutImages images_;  ///< of rows_ and cut_
  CutEpisodes cut_;
  MinibatchOrder order_;  ///< of the rollout's rows, in this epoch
  SliceMemory memory_;
  std::vector<std::uint8_t> begins_;  ///< environments to reset

  DiscountedReturns discounted_;  ///< for each row of a step
  std::vector<double> returns_;   ///< undiscounted return, for each environment
  std::vector<float> episode_returns_;
  std::vector<double> rollout_sums_, advantage_sums_;
  Gradients gradients_;
};

}  // namespace skybody::learn
