// Accelerations of body frames from the generalised ones: the derivative of forward kinematics
// (kinematics.h). For looking at; the step itself does not need them.
#pragma once

#include <vector>

#include "core/physics/bodies/kinematics.h"

namespace skybody {

/// How the motion of one body frame changes: the derivative of BodyState's two velocities.
struct BodyAcceleration {
  Vec3<double> linear{0.0, 0.0, 0.0};   ///< of the origin, W axes [m/s^2]; gravity is part of it
  Vec3<double> angular{0.0, 0.0, 0.0};  ///< B axes [rad/s^2]
};

/// Accelerations of all bodies, in the order of `tree`.
/// @param motion  of all bodies at q, u
/// @param udot    generalised accelerations, one per u
/// @param out     per body, overwritten
void body_accelerations(const std::vector<TreeBody>& tree, const double* q, const double* u,
                        const double* udot, const BodyKinematics<double>* motion,
                        BodyAcceleration* out);
/// The same, with the motion made.
/// @param udot  generalised accelerations, one per u
std::vector<BodyAcceleration> body_accelerations(const std::vector<TreeBody>& tree, const double* q,
                                                 const double* u, const double* udot);

}  // namespace skybody
