// One environment's physical values, contiguous: the initial state of a reset.
#pragma once

#include <array>
#include <vector>

#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "core/model/state_layout.h"

namespace skybody {

/// Position and motion of one body frame. 13 doubles in this order everywhere, including plugins.
struct BodyState {
  Vec3<double> position{0.0, 0.0, 0.0};          ///< origin in W [m]
  Quat<double> rotation{1.0, 0.0, 0.0, 0.0};     ///< W from B
  Vec3<double> velocity{0.0, 0.0, 0.0};          ///< of the origin, W axes [m/s]
  Vec3<double> angular_velocity{0.0, 0.0, 0.0};  ///< B axes [rad/s]
};
static_assert(sizeof(BodyState) == 13 * sizeof(double));

/// Values of one lane gathered from state words, in the order of the layout's blocks.
struct LaneState {
  std::vector<double> q, u, rotor_speed, rotor_command, wrench, drive, params;
  std::vector<double> joint_command, joint_state, coupling_forces, bristles;
  std::array<std::vector<double>, SKYBODY_HELD_COUNT> held;  ///< in the order of SkybodyHeldInput
  std::vector<BodyState> bodies;  ///< poses and velocities that belong to q and u
};

/// A block of state words and its vector in LaneState. The blocks of held inputs are not in this
/// list.
struct LaneBlock {
  std::vector<double> LaneState::*values;
  Block StateLayout::*place;
};
inline constexpr LaneBlock kLaneBlocks[] = {
    {&LaneState::q, &StateLayout::q},
    {&LaneState::u, &StateLayout::u},
    {&LaneState::rotor_speed, &StateLayout::rotor_speed},
    {&LaneState::rotor_command, &StateLayout::rotor_command},
    {&LaneState::wrench, &StateLayout::wrench},
    {&LaneState::drive, &StateLayout::drive},
    {&LaneState::params, &StateLayout::params},
    {&LaneState::joint_command, &StateLayout::joint_command},
    {&LaneState::joint_state, &StateLayout::joint_state},
    {&LaneState::coupling_forces, &StateLayout::coupling_forces},
    {&LaneState::bristles, &StateLayout::bristles}};

/// The values of a lane state that belong to a block.
inline std::vector<double>& values_of(LaneState& state, Block StateLayout::*place) {
  const LaneBlock* block = kLaneBlocks;
  while (block->place != place) ++block;
  return state.*block->values;
}

}  // namespace skybody
