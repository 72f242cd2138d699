// The states of a policy with a memory, for the rows of a slice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "learn/network/policy_network.h"

namespace skybody::learn {

/// The memory of each row of a step: its current state, that at the beginning of the rollout, and
/// the beginnings of episodes. Without units all functions do nothing.
class SliceMemory {
 public:
  /// @param units        of the policy's memory; 0: none
  /// @param steps, rows  of a rollout
  SliceMemory(int units, int steps, int rows);

  bool exists() const { return stride_ > 0; }
  /// Floats of a state.
  int stride() const { return stride_; }

  /// Begins a rollout with the current states.
  void begin();
  /// Adds the memory of rows first ... first + count of a step, read and then overwritten by the
  /// network, to `steps`. @param at  index of the first row in the rollout
  void recall(std::size_t at, int first, int count, PolicySteps& steps);
  /// Sets whether a row's next step begins an episode.
  void set_fresh(int row, bool is_fresh) {
    if (exists()) is_fresh_[static_cast<std::size_t>(row)] = is_fresh ? 1 : 0;
  }
  /// Adds the memory before whole sequences of the rollout to `steps`, which has `count` rows.
  /// @param order           their rows' indices, sequence by sequence
  /// @param begins, states  scratch memory: one per row, one state per sequence
  void gather(const int* order, int count, std::uint8_t* begins, float* states,
              PolicySteps& steps) const;

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h). @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".states", self.states_.data(), self.states_.size());
    visitor(name + ".is_fresh", self.is_fresh_.data(), self.is_fresh_.size());
  }

 private:
  int stride_ = 0, steps_;
  AlignedArray<float> states_;                ///< current, for each row of a step
  AlignedArray<float> first_states_;          ///< at the beginning of the rollout
  std::vector<std::uint8_t> is_fresh_;        ///< for each row of a step: its episode begins
  std::vector<std::uint8_t> episode_begins_;  ///< for each row of the rollout
};

}  // namespace skybody::learn
