// Proximal policy optimisation in one process: `--algo fast-ppo`.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "learn/learner.h"
#include "learn/ppo/ppo_driver.h"
#include "learn/ppo/ppo_slices.h"
#include "learn/ppo/task_crew.h"

namespace skybody::learn {

/// A PpoDriver and all slices, on the threads of this process. Two meetings a minibatch: all slices
/// have their gradients; both networks have been stepped.
///
/// Episodes end in three ways. A terminated one is worth nothing further. A truncated one is worth
/// what the value function says of its last observation, before the reset. A fault is worth nothing
/// further, and its transition has no reward.
class Ppo : public Learner {
 public:
  /// @throws Error as PpoSetup
  explicit Ppo(const LearnerOptions& options);

  std::int64_t steps() const override { return driver_.steps(); }
  Report iterate() override;
  PolicyFile policy() const override { return driver_.policy(); }
  std::uint64_t parameter_hash() const override { return driver_.parameter_hash(); }
  LearnerState state() const override;
  void restore(const LearnerState& state) override;

 private:
  void update();
  void add_episodes(Report& report) const;
  SliceSums sums_of(std::span<const double> (PpoSlice::*sums)() const);
  SliceGradients gradients_of(std::span<const float> (PpoSlice::*gradient)() const,
                              std::vector<const float*>& gradients);

  std::shared_ptr<const PpoSetup> setup_;
  TaskCrew crew_;
  PpoDriver driver_;
  PpoSlices slices_;
  std::vector<std::span<const double>> sums_;
  std::vector<const float*> policy_gradients_, value_gradients_;
};

}  // namespace skybody::learn
