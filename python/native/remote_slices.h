// Slices of a PPO held by Python objects, such as actors of Ray.
#pragma once

#include <nanobind/nanobind.h>

#include <vector>

#include "learn/ppo/slice_holder.h"

namespace skybody::python {

/// Calls the methods of a Python object, which return lists with one entry per slice:
///
///   collect(policy, value, iteration, mean, scale, return_mean)   (sums, episode returns)
///   find_advantages(reward_scale)                                 sums
///   find_gradients(policy, value, epoch, index, wants_policy, wants_value, mean, scale)
///                                                                 (sums, policy's, value's)
///   stagger_resets(iteration)
///   save()                                                        (blocks, words)
///   restore(states)                                               states: entries as from save()
///
/// If the object raises SlicesLost, the methods here throw it too. Takes the GIL for each call.
class RemoteSlices : public learn::SliceHolder {
 public:
  /// @param count  number of all slices
  RemoteSlices(nanobind::object holder, int count);
  ~RemoteSlices() override;

  int count() const override { return static_cast<int>(outputs_.size()); }
  void collect(const learn::RolloutInputs& inputs, const learn::PpoNetworks& networks) override;
  void find_advantages(double reward_scale, const learn::PpoNetworks& networks) override;
  void find_gradients(const learn::Minibatch& minibatch,
                      const learn::PpoNetworks& networks) override;
  void stagger_resets(std::int64_t iteration) override;
  learn::SliceOutputs outputs(int k) const override;
  std::vector<std::uint64_t> save(int k, learn::StateBlocks& blocks) const override;
  void check(int k, const learn::StateBlocks& blocks) override;
  void restore(int k, const learn::StateBlocks& blocks,
               std::span<const std::uint64_t> environments) override;

 private:
  struct Outputs {
    std::vector<double> rollout_sums, advantage_sums, minibatch_sums;
    std::vector<float> policy_gradient, value_gradient, episode_returns;
  };

  nanobind::object holder_;
  std::vector<Outputs> outputs_;
  mutable nanobind::object saved_;  ///< of all slices; None after further steps
  nanobind::list restored_;         ///< of the slices restored so far
};

/// Calls Python, and converts a loss of workers to the C++ exception. Requires the GIL.
template <class Call>
auto calling(Call&& call) {
  try {
    return call();
  } catch (nanobind::python_error& error) {
    const nanobind::object lost = nanobind::module_::import_("skybody._native").attr("SlicesLost");
    if (error.matches(lost)) throw learn::SlicesLost(error.what());
    throw;
  }
}

/// A slice's state for Python: a dictionary of blocks, and the environments' words.
nanobind::tuple state_of(const learn::StateBlocks& blocks,
                         std::span<const std::uint64_t> environments);
/// The inverse of state_of().
std::vector<std::uint64_t> read_state(nanobind::handle state, learn::StateBlocks& blocks);

}  // namespace skybody::python
