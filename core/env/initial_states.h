// Initial states of robots, as EnvParams: pose and motion of floating bases, rotor speeds,
// positions and velocities of joints.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/env/state_group.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The EnvParams of initial states, and the words of q, u and rotor speeds that a reset computes
/// from them. Immutable. `places` below are indices of such pieces: a position, a rotation with its
/// turn, a velocity, the speed of a rotor, a joint's position or velocity.
class InitialStates {
 public:
  InitialStates() = default;
  /// Appends the EnvParams to the layout, with the scenario's own start as their nominal values.
  InitialStates(const Topology& topology, StateLayout& layout);

  bool has(int param) const { return first_ <= param && param < end_; }
  /// The places that these EnvParams belong to, each once, in order.
  std::vector<int> places_of(const std::vector<int>& params) const;

  /// Places the lanes' robots according to their EnvParams: at all places, or only at the given
  /// ones.
  void place(StateGroup& group, std::uint32_t mask) const;
  void place(StateGroup& group, std::uint32_t mask, const std::vector<int>& places) const;

 private:
  struct Place {
    Block StateLayout::*block;  ///< q, u or rotor_speed
    int first;                  ///< first word within the block
    int param, count;           ///< EnvParams that are copied there
    int turn = -1;   ///< for a rotation: the first of three EnvParams of the turn; else -1
    int limit = -1;  ///< for a rotor: the EnvParam of its greatest speed; else -1
  };
  struct Author;
  static void place(StateGroup& group, std::uint32_t mask, const StateLayout& layout,
                    const Place& place);

  std::vector<Place> places_;
  int first_ = 0, end_ = 0;  ///< range of EnvParams
};

}  // namespace skybody
