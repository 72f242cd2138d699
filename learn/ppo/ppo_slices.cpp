#include "learn/ppo/ppo_slices.h"

#include "core/base/system/error.h"

namespace skybody::learn {

PpoSlices::PpoSlices(std::shared_ptr<const PpoSetup> setup, int first, int count,
                     LearnerThreads& threads)
    : threads_(threads) {
  if (first < 0 || count < 1 || first + count > setup->plan.slices()) {
    throw Error("slices " + std::to_string(first) + " to " + std::to_string(first + count - 1) +
                " are wanted; allowed: 0 to " + std::to_string(setup->plan.slices() - 1) +
                ", at least one");
  }
  for (int k = 0; k < count; ++k) {
    slices_.push_back(std::make_unique<PpoSlice>(setup, first + k));
  }
  for (int t = 0; t < threads.threads(); ++t) {
    scratch_.push_back(std::make_unique<SliceScratch>(*setup));
  }
}

void PpoSlices::collect(const RolloutInputs& inputs, const PpoNetworks& networks) {
  threads_.run(count(), [&](int k, int thread) {
    slices_[static_cast<std::size_t>(k)]->collect(inputs, networks,
                                                  *scratch_[static_cast<std::size_t>(thread)]);
  });
}

void PpoSlices::find_advantages(double reward_scale, const PpoNetworks& networks) {
  threads_.run(count(), [&](int k, int thread) {
    slices_[static_cast<std::size_t>(k)]->find_advantages(
        reward_scale, networks, *scratch_[static_cast<std::size_t>(thread)]);
  });
}

void PpoSlices::find_gradients(const Minibatch& minibatch, const PpoNetworks& networks) {
  threads_.run(count(), [&](int k, int thread) {
    slices_[static_cast<std::size_t>(k)]->find_gradients(
        minibatch, networks, *scratch_[static_cast<std::size_t>(thread)]);
  });
}

void PpoSlices::stagger_resets(std::int64_t iteration) {
  threads_.run(count(), [&](int k, int) {
    slices_[static_cast<std::size_t>(k)]->stagger_resets(iteration);
  });
}

SliceOutputs PpoSlices::outputs(int k) const {
  const PpoSlice& held = slice(k);
  return {held.rollout_sums(),    held.advantage_sums(), held.minibatch_sums(),
          held.policy_gradient(), held.value_gradient(), held.episode_returns()};
}

std::vector<std::uint64_t> PpoSlices::save(int k, StateBlocks& blocks) const {
  StateWriter writer(blocks);
  PpoSlice::visit(slice(k), writer);
  return slice(k).save_environments();
}

void PpoSlices::check(int k, const StateBlocks& blocks) {
  StateReader reader(blocks, StateReader::Mode::kCheck);
  PpoSlice::visit(*slices_[static_cast<std::size_t>(k)], reader);
}

void PpoSlices::restore(int k, const StateBlocks& blocks,
                        std::span<const std::uint64_t> environments) {
  check(k, blocks);
  PpoSlice& slice = *slices_[static_cast<std::size_t>(k)];
  slice.restore_environments(environments);
  StateReader reader(blocks, StateReader::Mode::kCopy);
  PpoSlice::visit(slice, reader);
}

}  // namespace skybody::learn
