// `dynamics: auto` where bodies may touch other robots or obstacles: the tree dynamics while
// nothing is within reach (reach.h), else Simbody with its contact. Which of them takes a physics
// step is a function of the motion at its start alone: no hysteresis, nothing to save and restore.
#pragma once

#include <memory>

#include "core/physics/dynamics.h"

namespace skybody {

/// Before the first begin_step it is the tree dynamics. Simbody's system (memory and milliseconds,
/// and the only allocations) is made when something first is within reach, and kept.
/// @param world  must outlive the dynamics
/// @throws Error (naming the body) if no rigid body can have the nominal mass properties
std::unique_ptr<Dynamics> make_hand_over_dynamics(const World& world);

}  // namespace skybody
