// Accelerations of body frames from generalised accelerations: the derivative of forward kinematics
// (kinematics.h). On double and packs.
#pragma once

#include <vector>

#include "core/physics/bodies/kinematics.h"

namespace skybody {

/// Acceleration of one body frame: the derivative of BodyState's two velocities.
template <class Real>
struct BodyAccelerationOf {
  Vec3<Real> linear;   ///< of the origin, W axes [m/s^2]; includes gravity
  Vec3<Real> angular;  ///< B axes [rad/s^2]
};
using BodyAcceleration = BodyAccelerationOf<double>;

namespace detail {

/// Accelerations of a frame, both in W axes.
template <class Real>
struct FrameAcceleration {
  Vec3<Real> linear, angular;

  /// Linear acceleration of a point fixed to the frame, at `arm` [m].
  SKYBODY_INLINE Vec3<Real> at(const Vec3<Real>& w, const Vec3<Real>& arm) const {
    return linear + cross(angular, arm) + cross(w, cross(w, arm));
  }
};

/// Derivative of JointMotion's two velocities, each in its own axes.
template <class Real>
SKYBODY_INLINE FrameAcceleration<Real> joint_acceleration(JointType type, const Real* q,
                                                          const Real* u, const Real* udot) {
  const Real zero(0.0);
  FrameAcceleration<Real> a{{zero, zero, zero}, {zero, zero, zero}};
  switch (type) {
    case JointType::kWeld:
      break;
    case JointType::kFree:
      a = {load_vec3(udot), load_vec3(udot + 3)};
      break;
    case JointType::kPin:
      a.angular.z = udot[0];
      break;
    case JointType::kSlider:
      a.linear.x = udot[0];
      break;
    case JointType::kUniversal: {
      const SinCos<Real> y = sincos(q[1]);
      a.angular = {y.cos * udot[0] - y.sin * u[1] * u[0], udot[1],
                   y.sin * udot[0] + y.cos * u[1] * u[0]};
      break;
    }
    case JointType::kBall:
      a.angular = load_vec3(udot);
      break;
  }
  return a;
}

}  // namespace detail

/// Accelerations of the bodies [first, last) in the order of `tree`. They must not depend on bodies
/// outside this range.
/// @param motion  of all bodies at q, u
/// @param udot    generalised accelerations, one per u
/// @param out     per body, overwritten
template <class Real>
SKYBODY_INLINE void body_accelerations(const std::vector<TreeBody>& tree, int first, int last,
                                       const Real* q, const Real* u, const Real* udot,
                                       const BodyKinematics<Real>* motion,
                                       BodyAccelerationOf<Real>* out) {
  const Real zero(0.0);
  for (int i = first; i < last; ++i) {
    const TreeBody& body = tree[static_cast<std::size_t>(i)];
    const BodyKinematics<Real>& m = motion[i];
    const JointMotion<Real> joint = joint_motion(body.type, q + body.q, u + body.u);
    const auto relative =
        detail::joint_acceleration(body.type, q + body.q, u + body.u, udot + body.u);
    const BodyKinematics<Real> frame = frame_on_parent(body, motion);
    detail::FrameAcceleration<Real> a{{zero, zero, zero}, {zero, zero, zero}};  // of F
    if (body.parent >= 0) {
      const BodyKinematics<Real>& parent = motion[body.parent];
      a = {out[body.parent].linear, parent.axes * out[body.parent].angular};
      a.linear = a.at(frame.angular_velocity, frame.position - parent.position);
    }
    // Of M, which moves in F while F moves.
    a.linear = a.at(frame.angular_velocity, frame.axes * joint.translation) +
               2.0 * cross(frame.angular_velocity, frame.axes * joint.velocity) +
               frame.axes * relative.linear;
    const Mat3<Real> m_axes = to_mat3(frame.rotation * joint.rotation);
    a.angular +=
        cross(frame.angular_velocity, m_axes * joint.angular_velocity) + m_axes * relative.angular;
    // Of the body's own frame, which is fixed to M.
    const Vec3<Real> arm = m.axes * to_real<Real>(body.frame_in_body.position);
    a.linear = a.at(m.angular_velocity, -arm);
    out[i] = {a.linear, transpose_times(m.axes, a.angular)};
  }
}

/// Of all bodies.
void body_accelerations(const std::vector<TreeBody>& tree, const double* q, const double* u,
                        const double* udot, const BodyKinematics<double>* motion,
                        BodyAcceleration* out);
/// The same; computes the motion from q and u.
/// @param udot  generalised accelerations, one per u
std::vector<BodyAcceleration> body_accelerations(const std::vector<TreeBody>& tree, const double* q,
                                                 const double* u, const double* udot);

}  // namespace skybody
