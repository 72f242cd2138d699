// Proximal policy optimisation: `--algo fast-ppo`.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "learn/common/learner_threads.h"
#include "learn/learner.h"
#include "learn/ppo/ppo_driver.h"
#include "learn/ppo/slice_holder.h"

namespace skybody::learn {

/// A PpoDriver and all slices. Two synchronisation points per minibatch: when all slices have their
/// gradients, and when both networks have been stepped.
///
/// Value after the end of an episode:
///   - terminated: 0;
///   - truncated: the value function at its last observation, before the reset;
///   - fault: 0, and its transition has no reward.
class Ppo : public Learner {
 public:
  /// @throws Error as PpoSetup
  explicit Ppo(const LearnerOptions& options);
  /// With slices held elsewhere.
  /// @param slices   all of setup->plan
  /// @param threads  number of threads that step the networks
  Ppo(std::shared_ptr<const PpoSetup> setup, std::unique_ptr<SliceHolder> slices, int threads);

  std::int64_t steps() const override { return driver_.steps(); }
  Report iterate() override;
  PolicyFile policy() const override { return driver_.policy(); }
  std::uint64_t parameter_hash() const override { return driver_.parameter_hash(); }
  LearnerState state() const override;
  void restore(const LearnerState& state) override;

 private:
  void update();
  void check_environments(std::span<const std::uint64_t> words) const;
  void restore_slices(const LearnerState& state);
  void add_episodes(Report& report) const;
  SliceSums sums_of(std::span<const double> SliceOutputs::*sums);
  SliceGradients gradients_of(std::span<const float> SliceOutputs::*gradient,
                              std::vector<const float*>& gradients);

  std::shared_ptr<const PpoSetup> setup_;
  std::unique_ptr<LearnerThreads> threads_;  // before the slices, which use it
  PpoDriver driver_;
  std::unique_ptr<SliceHolder> slices_;
  std::vector<std::span<const double>> sums_;
  std::vector<const float*> policy_gradients_, value_gradients_;
};

}  // namespace skybody::learn
