// A PPO whose slices are held by workers that may die.
#pragma once

#include <functional>
#include <memory>

#include "learn/learner.h"
#include "learn/ppo/ppo.h"

namespace skybody::learn {

/// Keeps the state after the last iteration. If workers die in the next one, it replaces them,
/// restores all slices, and repeats the iteration: the same bits as without a failure.
class RecoveringPpo : public Learner {
 public:
  /// @param replace  restarts the holders of slices, in any state
  /// @throws Error as Ppo, SlicesLost
  RecoveringPpo(std::shared_ptr<const PpoSetup> setup, std::unique_ptr<SliceHolder> slices,
                int threads, std::function<void()> replace);

  std::int64_t steps() const override { return ppo_.steps(); }
  /// @throws Diverged; SlicesLost if workers die again and again
  Report iterate() override;
  PolicyFile policy() const override { return ppo_.policy(); }
  std::uint64_t parameter_hash() const override { return ppo_.parameter_hash(); }
  LearnerState state() const override { return kept_; }
  void restore(const LearnerState& state) override;

 private:
  static constexpr int kMostTries = 20;  ///< per iteration

  Report iterate_and_keep();

  Ppo ppo_;
  std::function<void()> replace_;
  LearnerState kept_;
};

}  // namespace skybody::learn
