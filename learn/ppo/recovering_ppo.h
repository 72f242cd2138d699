// A PPO whose slices are held elsewhere and may be lost.
#pragma once

#include <functional>
#include <memory>

#include "learn/learner.h"
#include "learn/ppo/ppo.h"

namespace skybody::learn {

/// Keeps the words of the last iteration. Where workers die in the next one, they are replaced, all
/// slices are put back, and the iteration is done again: the same bits as if nobody had died.
class RecoveringPpo : public Learner {
 public:
  /// @param replace  brings the holders of slices to life again, with any state
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
  static constexpr int kMostTries = 20;  ///< of one iteration

  Report iterate_and_keep();

  Ppo ppo_;
  std::function<void()> replace_;
  LearnerState kept_;
};

}  // namespace skybody::learn
