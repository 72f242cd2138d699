// The state in which a world begins before any randomizer has been asked.
#pragma once

#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A lane state of the right sizes, all zero; what effects hold has its neutral values.
LaneState make_lane_state(const World& world);

/// Nominal parameters, the scenario's poses, zero velocities, joints where the scenario has them,
/// rotors at the scenario's speed, held to their greatest (commanded to stay there), no wrenches,
/// drives at rest at the present pose, position drives of joints where those are.
/// Resizes the vectors of `state` where needed; bodies are made current.
void write_default_state(const World& world, LaneState& state);

/// The speed [rad/s] at which a robot's rotors, all at the same one, carry its nominal weight:
/// sqrt(m |g| / sum of k_f a_z), a_z being the z of the rotor's axis in its body's frame. It may be
/// more than rotors can do. 0 where that sum is not positive.
double hover_rotor_speed(const Scenario& scenario, int robot);

/// The speed [rad/s] at which a rotor of the world begins: the scenario's, held to its greatest.
double start_rotor_speed(const Topology& world, int rotor);

}  // namespace skybody
