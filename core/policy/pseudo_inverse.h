// Geometry that the hold baseline needs: how rotors share a wanted thrust and torque.
#pragma once

#include <string>
#include <vector>

#include "core/physics/world/world.h"

namespace skybody {

/// Thrusts [N] from (collective thrust along z [N], torque about the base's centre of mass [N m],
/// base axes): rotors x 4, row by row, the pseudo-inverse B^T (B B^T)^-1 of an environment's
/// geometry. Rotors that push downwards and cannot turn backwards have rows of 0. Empty where
/// allocation_obstacle() is not.
/// @param params  of the environment
std::vector<double> allocation_of(const World& world, int robot, const std::vector<double>& params);

/// The reason why a robot's rotors do not give thrust and torques as a rigid body's do; empty: they
/// do.
std::string allocation_obstacle(const World& world, int robot);

/// How far a point of `body` [m, its frame] lies below the origin of `base` with all joints at 0
/// [m]; less than 0 where it stands above.
double hanging_length(const World& world, int base, int body, const Vec3<double>& point);

}  // namespace skybody
