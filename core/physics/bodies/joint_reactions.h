// Forces of joints on their bodies: Newton-Euler equations from the leaves to the bases, for given
// motion and forces (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, table 5.1). For sensors
// and tasks; the step does not need them.
#pragma once

#include "core/physics/bodies/body_accelerations.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Force and moment of each body's inboard joint on the body, about its origin, W axes [N, N m]:
/// the sum of constraint, spring, damper, limit and drive. For a base: the force that holds or
/// drives it; 0 up to round-off if it moves freely.
/// @param params         the parameter block
/// @param motion, accelerations, loads  per body; loads: all forces except those of joints, W axes
///                       about the body's origin
/// @param out            per body, overwritten
void joint_reactions(const World& world, const double* params, const BodyKinematics<double>* motion,
                     const BodyAcceleration* accelerations, const SpatialForce<double>* loads,
                     SpatialForce<double>* out);

}  // namespace skybody
