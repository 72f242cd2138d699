// Where the slices of a PPO are: in this process, or held by workers on other machines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "learn/common/state_blocks.h"
#include "learn/ppo/ppo_messages.h"
#include "learn/ppo/ppo_networks.h"

namespace skybody::learn {

/// A holder cannot give what was asked: workers died. The iteration can be done again.
class SlicesLost : public Error {
 public:
  using Error::Error;
};

/// Outputs of a slice, until the next call. Empty where nothing was asked.
struct SliceOutputs {
  std::span<const double> rollout_sums;    ///< of RolloutSum, after collect()
  std::span<const double> advantage_sums;  ///< of AdvantageSum, after find_advantages()
  std::span<const double> minibatch_sums;  ///< of MinibatchSum, after find_gradients()
  std::span<const float> policy_gradient;  ///< as PpoNetworks::policy_parameters() lies
  std::span<const float> value_gradient;   ///< as PpoNetworks::value_parameters() lies
  std::span<const float> episode_returns;  ///< of the episodes that ended in the rollout
};

/// Runs the phases of all slices, in the order in which PpoDriver asks. What a slice gives does not
/// depend on who holds it, nor on what else he holds.
class SliceHolder {
 public:
  virtual ~SliceHolder() = default;

  virtual int count() const = 0;
  virtual void collect(const RolloutInputs& inputs, const PpoNetworks& networks) = 0;
  virtual void find_advantages(double reward_scale, const PpoNetworks& networks) = 0;
  virtual void find_gradients(const Minibatch& minibatch, const PpoNetworks& networks) = 0;
  /// @param iteration  rollouts done
  virtual void stagger_resets(std::int64_t iteration) = 0;
  /// @param k  0 ... count() - 1
  virtual SliceOutputs outputs(int k) const = 0;

  /// Everything of slice k: words beside the environments' are added to `blocks`.
  /// @returns the environments' words
  virtual std::vector<std::uint64_t> save(int k, StateBlocks& blocks) const = 0;
  /// Whether `blocks` has slice k's. @throws Error if not
  virtual void check(int k, const StateBlocks& blocks) = 0;
  /// @throws Error if the words are not of these environments
  virtual void restore(int k, const StateBlocks& blocks,
                       std::span<const std::uint64_t> environments) = 0;
};

}  // namespace skybody::learn
