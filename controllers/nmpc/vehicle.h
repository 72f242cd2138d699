// The guide's model of a robot, from its nominal constants.
#pragma once

#include "controllers/nmpc/solver.h"
#include "plugins/api/setup.h"

namespace skybody::nmpc {

/// Fills in `model` and `rows`. @throws std::runtime_error where the robot's rotors cannot be
/// controlled so
void set_vehicle(const Setup& setup, int robot, NmpcProblem& guide);

}  // namespace skybody::nmpc
