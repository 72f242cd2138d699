// Consecutive slices of a PPO's environments: all of them, or those of a worker on another machine.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "learn/common/learner_threads.h"
#include "learn/common/state_blocks.h"
#include "learn/ppo/ppo_messages.h"
#include "learn/ppo/ppo_networks.h"
#include "learn/ppo/ppo_setup.h"
#include "learn/ppo/ppo_slice.h"
#include "learn/ppo/slice_holder.h"

namespace skybody::learn {

/// Runs the phases of its slices on a LearnerThreads, in the order given in PpoDriver. The results
/// of a slice do not depend on its holder or on the holder's other slices. Data is passed as plain
/// arrays. Inputs: parameters (by PpoNetworks::set), RolloutInputs, Minibatch. Outputs: sums and
/// gradients of each slice, valid until the next call.
class PpoSlices : public SliceHolder {
 public:
  /// Slices `first` ... first + count - 1 of setup->plan.
  /// @param threads  must outlive this object; may run other work between calls
  PpoSlices(std::shared_ptr<const PpoSetup> setup, int first, int count, LearnerThreads& threads);

  int count() const override { return static_cast<int>(slices_.size()); }
  void collect(const RolloutInputs& inputs, const PpoNetworks& networks) override;
  void find_advantages(double reward_scale, const PpoNetworks& networks) override;
  void find_gradients(const Minibatch& minibatch, const PpoNetworks& networks) override;
  void stagger_resets(std::int64_t iteration) override;
  SliceOutputs outputs(int k) const override;
  std::vector<std::uint64_t> save(int k, StateBlocks& blocks) const override;
  void check(int k, const StateBlocks& blocks) override;
  void restore(int k, const StateBlocks& blocks,
               std::span<const std::uint64_t> environments) override;

  /// @param k  0 ... count() - 1
  const PpoSlice& slice(int k) const { return *slices_[static_cast<std::size_t>(k)]; }

 private:
  LearnerThreads& threads_;
  std::vector<std::unique_ptr<PpoSlice>> slices_;
  std::vector<std::unique_ptr<SliceScratch>> scratch_;  ///< one per thread
};

}  // namespace skybody::learn
