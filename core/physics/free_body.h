// One rigid body that floats freely: its accelerations in closed form (Newton and Euler about the
// centre of mass), on double and packs.
#pragma once

#include "core/physics/body_constants.h"
#include "core/physics/spatial_force.h"

namespace skybody {

/// @param body       its motion
/// @param u          its coordinates' rates: velocity of the origin (W), angular velocity (body)
/// @param constants  kBodyConstantCount values: a pointer, or a view
/// @param force      on the body; @param joint_force  on its six coordinates
/// @param udot       six, overwritten
template <class Real, class Constants>
SKYBODY_INLINE void free_body_accelerations(const BodyKinematics<Real>& body, const Real* u,
                                            const Constants& constants,
                                            const SpatialForce<Real>& force,
                                            const Real* joint_force, Real* udot) {
  const Mat3<Real>& axes = body.axes;
  const Vec3<Real> w = load_vec3(u + 3);
  const Vec3<Real> com = load_vec3(constants + kBodyCom);
  const Vec3<Real> force_w = force.force + load_vec3(joint_force);
  const Vec3<Real> force_b = transpose_times(axes, force_w);
  const Vec3<Real> moment = transpose_times(axes, force.moment) + load_vec3(joint_force + 3);

  const Vec3<Real> about_com = moment - cross(com, force_b);
  const Vec3<Real> momentum = load_sym_mat3(constants + kBodyInertia) * w;
  const Vec3<Real> angular =
      load_sym_mat3(constants + kBodyInverseInertia) * (about_com - cross(w, momentum));
  const Vec3<Real> com_from_origin = cross(angular, com) + cross(w, cross(w, com));
  store(force_w * constants[kBodyInverseMass] - axes * com_from_origin, udot);
  store(angular, udot + 3);
}

}  // namespace skybody
