// Some environments of a PPO with their rollout: all that one thread does at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/batch/pool.h"
#include "learn/common/state_blocks.h"
#include "learn/ppo/gaussian.h"
#include "learn/ppo/normalizer.h"
#include "learn/ppo/policy_loss.h"
#include "learn/ppo/ppo_messages.h"
#include "learn/ppo/ppo_networks.h"
#include "learn/ppo/ppo_setup.h"

namespace skybody::learn {

/// Memory of a thread, for whichever slice it works on.
struct SliceScratch {
  explicit SliceScratch(const PpoSetup& setup);

  static constexpr int kRows = 128;  ///< that go through a network at a time
  int minibatch_rows;  ///< the same of a minibatch, where a policy with a memory sees sequences
  PolicyNetwork::Memory policy;
  NetworkActivations value;
  AlignedArray<float> rows;              ///< of a minibatch, gathered
  AlignedArray<float> output, gradient;  ///< of either network, for so many rows
  std::vector<std::uint8_t> begins;      ///< of the gathered rows, where there is a memory
  AlignedArray<float> states;            ///< before the gathered sequences, likewise
  PolicyLoss loss;
};

/// Slice `index` of the plan. Between two calls of the driver nothing is pending.
///
/// Rows of a step are the slice's environments, or their robots, one environment's after the
/// other's. Everything it draws follows from the seed, its rows and the iteration.
class PpoSlice {
 public:
  PpoSlice(std::shared_ptr<const PpoSetup> setup, int index);

  /// A rollout: fills the rows and the sums.
  void collect(const RolloutInputs& inputs, const PpoNetworks& networks, SliceScratch& scratch);
  /// Values of the rollout's observations, then generalized advantage estimation (Schulman et al.
  /// 2016, arXiv 1506.02438, eq. 16) of rewards times `reward_scale`.
  void find_advantages(double reward_scale, const PpoNetworks& networks, SliceScratch& scratch);
  /// Gradients of the slice's share of a minibatch, as parts of the minibatch's mean loss.
  void find_gradients(const Minibatch& minibatch, const PpoNetworks& networks,
                      SliceScratch& scratch);
  /// Begins the k-th of horizon / rollout_steps groups of environments anew after rollout k, so
  /// that later rollouts show all parts of an episode.
  /// @param iteration  rollouts done
  void stagger_resets(std::int64_t iteration);

  std::span<const double> rollout_sums() const { return rollout_sums_; }
  std::span<const double> advantage_sums() const { return advantage_sums_; }
  std::span<const double> minibatch_sums() const { return minibatch_sums_; }
  /// As PpoNetworks::policy_parameters() lies.
  std::span<const float> policy_gradient() const {
    return {gradients_[0].data(), gradients_[0].size()};
  }
  std::span<const float> value_gradient() const {
    return {gradients_[1].data(), gradients_[1].size()};
  }
  /// Of the episodes that ended in the rollout.
  std::span<const float> episode_returns() const { return episode_returns_; }

  /// The last rollout, for whoever wants to check what was learned from. Row r of step t is row
  /// t * rows_of_step + r; values and rows have those of the last observations behind.
  struct Rollout {
    int steps, rows_of_step;
    std::span<const float> rows;  ///< RowLayout; the last step's have inputs alone
    std::span<const float> reward, goes_on, bootstrap, value;
    std::span<const int> order;  ///< of the last epoch
  };
  Rollout rollout() const {
    return {steps_, step_rows_, {rows_.data(), rows_.size()}, reward_, goes_on_, bootstrap_,
            value_, order_};
  }

  /// Names to `visitor` what a checkpoint holds beside the environments.
  template <class Self, class Visitor>
  static void visit(Self& self, Visitor& visitor) {
    const std::string name = "slice" + std::to_string(self.index_);
    visitor(name + ".discounted", self.discounted_.data(), self.discounted_.size());
    visitor(name + ".returns", self.returns_.data(), self.returns_.size());
    visitor(name + ".states", self.states_.data(), self.states_.size());
    visitor(name + ".is_fresh", self.is_fresh_.data(), self.is_fresh_.size());
  }
  std::vector<std::uint64_t> save_environments() const { return pool_.save(); }
  void restore_environments(std::span<const std::uint64_t> words);

 private:
  float* row(int step, int row_of_step) {
    return rows_.data() + at(step, row_of_step) * static_cast<std::size_t>(stride_);
  }
  std::size_t at(int step, int row_of_step) const {
    return static_cast<std::size_t>(step) * static_cast<std::size_t>(step_rows_) +
           static_cast<std::size_t>(row_of_step);
  }
  void clear_sums();
  void copy_inputs(const float* observation, const float* privileged, int env, float* first);
  void write_inputs(int step, bool adds_sums);
  PolicySteps recall(int step, int first, int count);
  void choose_actions(int step, const PpoNetworks& networks, SliceScratch& scratch);
  void command(int step);
  void step_environments();
  void take_outcome(int step);
  void take_rewards(int step, int env);
  void end_episode(int step, int env);
  void value_cut_episodes(const PpoNetworks& networks, SliceScratch& scratch);
  void find_values(const PpoNetworks& networks, SliceScratch& scratch);
  void shuffle(int epoch);
  void gather(int first, int count, SliceScratch& scratch);
  PolicySteps gather_memory(int first, int count, SliceScratch& scratch) const;
  void add_policy_gradient(const Minibatch&, const PolicySteps&, const PpoNetworks&, SliceScratch&);
  void add_value_gradient(const Minibatch&, int count, const PpoNetworks&, SliceScratch&);
  void look_at_observations();

  std::shared_ptr<const PpoSetup> setup_;
  int index_, envs_, step_rows_, steps_, stride_;
  Normalizer normalizer_;
  Pool pool_;
  std::shared_ptr<const Batch> batch_;                          ///< of the last step
  const float *observation_ = nullptr, *privileged_ = nullptr;  ///< of all environments now
  std::vector<float> own_observation_, own_privileged_;         ///< where no batch has them
  const RolloutInputs* inputs_ = nullptr;                       ///< of the rollout under way
  std::int64_t iteration_ = 0;                                  ///< of the last rollout
  Deviations deviations_;

  AlignedArray<float> rows_;                         ///< steps + 1 times step_rows_; RowLayout
  std::vector<float> reward_, goes_on_, bootstrap_;  ///< of each row: 1 where the episode goes on;
                                                     ///< worth of what was cut off
  std::vector<float> value_;                  ///< of each row, the last observations included
  std::vector<float> following_;              ///< advantage of the step behind, of each row
  std::vector<float> noise_, mean_, action_;  ///< of a step
  AlignedArray<float> last_inputs_;           ///< of episodes that were cut off in a step
  std::vector<int> cut_;                      ///< their rows
  std::vector<int> order_;                    ///< of the rollout's rows, in this epoch
  std::vector<std::uint8_t> begins_;          ///< environments that begin anew

  // Of a policy with a memory, else empty:
  int state_stride_ = 0;
  AlignedArray<float> states_;                ///< of each row of a step, now
  AlignedArray<float> first_states_;          ///< at the beginning of the rollout
  std::vector<std::uint8_t> is_fresh_;        ///< of each row of a step: its episode begins
  std::vector<std::uint8_t> episode_begins_;  ///< of each row of the rollout, as order_ counts

  std::vector<double> discounted_;  ///< return so far, of each row of a step
  std::vector<double> returns_;     ///< likewise undiscounted, of each environment
  std::vector<float> episode_returns_;
  std::vector<double> rollout_sums_, advantage_sums_, minibatch_sums_;
  std::vector<double> log_std_gradient_;
  AlignedArray<float> gradients_[2];  ///< policy, value
};

}  // namespace skybody::learn
