// Interface to the slices of a PPO, in this process or on other machines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/system/error.h"
#include "learn/common/state_blocks.h"
#include "learn/ppo/ppo_messages.h"
#include "learn/ppo/ppo_networks.h"

namespace skybody::learn {

/// A holder cannot answer because workers died. The iteration can be repeated.
class SlicesLost : public Error {
 public:
  using Error::Error;
};

/// Outputs of a slice, valid until the next call. Arrays that were not computed are empty.
struct SliceOutputs {
  std::span<const double> rollout_sums;    ///< indexed by RolloutSum, after collect()
  std::span<const double> advantage_sums;  ///< indexed by AdvantageSum, after find_advantages()
  std::span<const double> minibatch_sums;  ///< indexed by MinibatchSum, after find_gradients()
  std::span<const float> policy_gradient;  ///< in the layout of PpoNetworks::policy_parameters()
  std::span<const float> value_gradient;   ///< in the layout of PpoNetworks::value_parameters()
  std::span<const float> episode_returns;  ///< of the episodes that ended in the rollout
};

/// Runs the phases of all slices, in the order given in PpoDriver. The results of a slice do not
/// depend on its holder or on the holder's other slices.
class SliceHolder {
 public:
  virtual ~SliceHolder() = default;

  virtual int count() const = 0;
  virtual void collect(const RolloutInputs& inputs, const PpoNetworks& networks) = 0;
  virtual void find_advantages(double reward_scale, const PpoNetworks& networks) = 0;
  virtual void find_gradients(const Minibatch& minibatch, const PpoNetworks& networks) = 0;
  /// @param iteration  completed rollouts
  virtual void stagger_resets(std::int64_t iteration) = 0;
  /// @param k  0 ... count() - 1
  virtual SliceOutputs outputs(int k) const = 0;

  /// Saves slice k: words other than the environments' are added to `blocks`.
  /// @returns the environments' words
  virtual std::vector<std::uint64_t> save(int k, StateBlocks& blocks) const = 0;
  /// Checks that `blocks` has the words of slice k. @throws Error if not
  virtual void check(int k, const StateBlocks& blocks) = 0;
  /// @throws Error if the words do not fit these environments
  virtual void restore(int k, const StateBlocks& blocks,
                       std::span<const std::uint64_t> environments) = 0;
};

}  // namespace skybody::learn
