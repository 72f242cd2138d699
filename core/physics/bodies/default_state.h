// The state in which a world begins before any randomizer has been asked.
#pragma once

#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A lane state of the right sizes, all zero; what effects hold has its neutral values.
LaneState make_lane_state(const World& world);

/// Nominal parameters, the scenario's poses, zero velocities, joints at zero, rotors at the
/// scenario's speed (commanded to stay there), no wrenches, drives at rest at the
/// present pose, position drives of joints where those are.
/// Resizes the vectors of `state` where needed; bodies are made current.
void write_default_state(const World& world, LaneState& state);

/// The speed at which a robot's rotors, all turning alike along their axes, carry its nominal
/// weight: sqrt(m |g| / sum of k_f) [rad/s], at most each rotor's maximum; 0 without rotors.
double hover_rotor_speed(const World& world, int robot);

}  // namespace skybody
