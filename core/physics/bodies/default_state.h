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

/// The frame of a body in that of its robot's base, with the joints as at a reset.
/// @param body  index into RobotModel::bodies
Pose place_at_reset(const RobotModel& model, int body);

/// The z of a rotor's push in the base's frame at a reset, where the rotor lifts, else 0. Below 0:
/// it lifts by turning backwards, which only rotors do that are reversible.
double lift_of(const RobotModel& model, const Rotor& rotor);

/// The speed [rad/s] at which the rotors that lift, all at the same one, some backwards, carry a
/// robot's nominal weight: sqrt(m |g| / sum of k_f |lift_of|). It may be more than rotors can do. 0
/// where no rotor lifts.
double hover_rotor_speed(const Scenario& scenario, int robot);

/// The speed [rad/s] at which a rotor of the world begins: the scenario's, held to its limits; of
/// `hover` below 0 where it lifts by turning backwards, 0 where it does not lift.
double start_rotor_speed(const Topology& world, int rotor);

}  // namespace skybody
