// What joints exert on the bodies that they move: Newton's and Euler's equations from the leaves to
// the bases, for motion and forces that are known (R. Featherstone, Rigid Body Dynamics Algorithms,
// 2008, table 5.1). For sensors and tasks; the step itself does not need them.
#pragma once

#include "core/physics/bodies/body_accelerations.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Force and moment of each body's inboard joint on the body, about its origin, W axes [N, N m]:
/// constraint, spring, damper, limit and drive together. Of a base what holds or drives it; of one
/// that moves freely 0 but for rounding.
/// @param params         the parameter block
/// @param motion, accelerations, loads  per body; loads: all forces but those of joints, W axes
///                       about the body's origin
/// @param out            per body, overwritten
void joint_reactions(const World& world, const double* params, const BodyKinematics<double>* motion,
                     const BodyAcceleration* accelerations, const SpatialForce<double>* loads,
                     SpatialForce<double>* out);

}  // namespace skybody
