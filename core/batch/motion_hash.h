// A hash of the motion alone, for tests that must hold while the layout of the state words changes.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/math/hash.h"
#include "core/batch/observer.h"

namespace skybody {

class Pool;

/// Chains, for each environment after each transition, q, u, rotor speeds, observation, privileged
/// row, images, reward and status: a trajectory hash with three blocks in place of all state words.
/// All NaNs count as equal. Observe a Pool with it (Pool::observe) before the first reset. Not for
/// Autoreset::kSameStep, where the state of the last transition is gone when its row arrives.
class MotionHash : public PoolObserver {
 public:
  explicit MotionHash(const Pool& envs);

  void received(const Batch& rows, const EnvironmentStates& states) override;
  /// The chains of all environments so far, combined in the order of their ids.
  std::uint64_t value() const;

 private:
  std::vector<HashChain> chains_;
};

}  // namespace skybody
