// The initial state of a world before randomizers are applied.
#pragma once

#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A lane state of the right sizes, all zero; held inputs have their neutral values.
LaneState make_lane_state(const World& world);

/// Writes the default initial state:
/// - nominal parameters,
/// - the scenario's poses and joint positions, zero velocities,
/// - rotors at the scenario's speed, clamped to their maximum, and commanded to keep it,
/// - no wrenches,
/// - drives at rest at the current pose, position drives of joints at the joint positions.
/// Resizes the vectors of `state` where needed and computes the bodies.
void write_default_state(const World& world, LaneState& state);

/// Pose of a body's frame in its robot's base frame, with the joints at their initial positions.
/// @param body  index into RobotModel::bodies
Pose place_at_reset(const RobotModel& model, int body);

/// z component of a rotor's thrust axis in the base frame at the initial positions; 0 if the rotor
/// does not lift. Negative: the rotor lifts by spinning backwards, which only reversible rotors do.
double lift_of(const RobotModel& model, const Rotor& rotor);

/// The rotor speed [rad/s] for hover: sqrt(m |g| / sum of k_f |lift_of|). All rotors that lift spin
/// at this speed, some backwards, and carry the robot's nominal weight. May exceed the rotors'
/// limits. 0 if no rotor lifts.
double hover_rotor_speed(const Scenario& scenario, int robot);

/// Initial speed [rad/s] of a rotor of the world: the scenario's, clamped to its limits. With
/// `hover`: negative if it lifts by spinning backwards, 0 if it does not lift.
double start_rotor_speed(const Topology& world, int rotor);

}  // namespace skybody
