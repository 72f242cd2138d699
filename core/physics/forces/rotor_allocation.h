// Rotor geometry: the distribution of a thrust and torque among rotors.
#pragma once

#include <string>
#include <vector>

#include "core/physics/world/world.h"

namespace skybody {

/// Thrusts [N] from (collective thrust along z [N], torque about the base's centre of mass [N m],
/// base axes): rotors x 4, row by row, the pseudo-inverse B^T (B B^T)^-1 of an environment's
/// geometry. Rotors that push downwards and cannot turn backwards have rows of 0. Empty if
/// allocation_obstacle() is not empty.
/// @param params  of the environment
std::vector<double> allocation_of(const World& world, int robot, const std::vector<double>& params);

/// The reason why a robot's rotors cannot produce the thrust and torques of a rigid body; empty:
/// they can.
std::string allocation_obstacle(const World& world, int robot);

}  // namespace skybody
