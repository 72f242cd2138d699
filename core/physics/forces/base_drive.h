// Kinematic drives: the motion of a robot's free base is prescribed, whatever the forces. Its u is
// set at the start of a physics step and stays constant. Its accelerations are zero; joints further
// out react to its motion.
#pragma once

#include "core/base/math/math.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The rotation vector of a unit quaternion: axis times angle [rad], by the shorter way.
template <class Real>
SKYBODY_INLINE Vec3<Real> rotation_vector(const Quat<Real>& q) {
  const Real sine = sqrt((q.x * q.x + q.y * q.y) + q.z * q.z);
  const Real sign = select(q.w < 0.0, Real(-1.0), Real(1.0));
  const auto small = sine < 1e-9;
  const Real angle = 2.0 * atan2(sine, q.w * sign);
  const Real scale = sign * select(small, Real(2.0), angle / select(small, Real(1.0), sine));
  return {q.x * scale, q.y * scale, q.z * scale};
}

/// Velocity drive: u of a free base from the desired velocity and angular velocity, base axes.
/// @param base  the base's current motion
template <class Real>
SKYBODY_INLINE void drive_velocity(const BodyKinematics<Real>& base, const Real* drive, Real* u) {
  store(base.axes * load_vec3(drive + kDriveVelocity), u);
  store(load_vec3(drive + kDriveAngularVelocity), u + 3);
}

/// Pose drive: the constant u that moves a free base from q to `target` within `dt` seconds.
/// @param target  pose in W: position (3), unit quaternion (4)
template <class Real>
SKYBODY_INLINE void drive_to_pose(const Real* q, const Real* target, double dt, Real* u) {
  store((load_vec3(target) - load_vec3(q)) / Real(dt), u);
  const Quat<Real> turn = conjugate(load_quat(q + 3)) * load_quat(target + 3);
  store(rotation_vector(turn) / Real(dt), u + 3);
}

}  // namespace skybody
