// Prediction model of a robot, from its nominal constants.
#pragma once

#include "controllers/nmpc/solver.h"
#include "plugins/api/setup.h"

namespace skybody::nmpc {

/// Fills `model` and `rows`. @throws std::runtime_error if the controller does not support the
/// robot's rotors
void set_vehicle(const Setup& setup, int robot, NmpcProblem& guide);

}  // namespace skybody::nmpc
