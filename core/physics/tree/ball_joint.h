// A ball joint in the articulated-body algorithm. It holds its body at a point, M's origin. It
// transmits a force, and no moment except its own joint force. All three rotations of the body are
// eliminated at once, in W axes; the body and its subtree then act as an inertia at that point
// alone. With the motion about M's origin, whose acceleration is a,
//   tau = A alpha + C a + b_m        so  alpha = A^-1 (tau - b_m) - A^-1 C a
//   f   = C^T alpha + L a + b_f      so  f = (L - C^T A^-1 C) a + b_f + C^T A^-1 (tau - b_m)
#pragma once

#include "core/physics/tree/articulated_body.h"

namespace skybody {

/// Results of a ball joint's elimination, kept for the pass from the base to the leaves.
template <class Real>
struct BallJointCache {
  Mat3<Real> axes;       ///< of M, in W
  Vec3<Real> lever;      ///< from M's origin to O, W axes [m]
  Vec3<Real> free_turn;  ///< A^-1 (tau - b_m): alpha for a = 0 [rad/s^2]
  Mat3<Real> follow;     ///< A^-1 C: reduction of alpha per a [rad/m]
};

/// Drift and arm of the joint, both to M's origin.
/// @param parent  null where the joint's frame F is fixed to W
template <class Real>
SKYBODY_INLINE void open_ball(const TreeBody& tree, const BodyKinematics<Real>* parent,
                              const BodyKinematics<Real>& body, ArticulatedBodyCache<Real>& work,
                              BallJointCache<Real>& ball) {
  const Real none(0.0);
  ball.axes = body.axes;
  ball.lever = {none, none, none};
  work.arm = body.position;
  if (!tree.plain_body) {
    ball.axes = body.axes * to_mat3(to_real<Real>(tree.frame_in_body.rotation));
    ball.lever = -(body.axes * to_real<Real>(tree.frame_in_body.position));
    work.arm -= ball.lever;
  }
  work.drift = {{none, none, none}, {none, none, none}};
  if (parent == nullptr) return;
  const Vec3<Real>& w = parent->angular_velocity;
  work.arm -= parent->position;
  work.drift = {cross(w, body.angular_velocity - w), cross(w, cross(w, work.arm))};
}

/// Acceleration of O for a = 0 and alpha = 0: the centripetal acceleration at the lever.
template <class Real>
SKYBODY_INLINE Vec3<Real> swing(const BodyKinematics<Real>& body,
                                const BallJointCache<Real>& ball) {
  const Vec3<Real>& w = body.angular_velocity;
  return cross(w, cross(w, ball.lever));
}

/// Eliminates the joint from the equations of its body.
/// @param force  of the joint on its body, M axes [N m]
/// @param linear  overwritten: the inertia at M's origin
/// @param bias    overwritten: about M's origin, the force needed if the parent does not accelerate
template <class Real>
SKYBODY_INLINE void take_out_ball(const TreeBody& tree, const BodyKinematics<Real>& body,
                                  const Real* force, const ArticulatedBodyCache<Real>& work,
                                  BallJointCache<Real>& ball, SymMat3<Real>& linear,
                                  SpatialForce<Real>& bias) {
  ArticulatedInertia<Real> inertia = work.inertia;
  bias = work.bias;
  if (!tree.plain_body) {
    const Vec3<Real> swinging = swing(body, ball);
    bias.moment += inertia.coupling * swinging;
    bias.force += inertia.linear * swinging;
    inertia = shifted(inertia, ball.lever);
    bias = shifted(bias, ball.lever);
  }
  const Ldl3<Real> turning(inertia.angular);
  const Mat3<Real>& c = inertia.coupling;
  const Vec3<Real> x = turning.solve(c.column(0)), y = turning.solve(c.column(1)),
                   z = turning.solve(c.column(2));
  const Vec3<Real> moment = ball.axes * load_vec3(force);
  ball.follow = {{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z}};
  ball.free_turn = turning.solve(moment - bias.moment);
  linear =
      inertia.linear - SymMat3<Real>{dot(c.column(0), x), dot(c.column(1), y), dot(c.column(2), z),
                                     dot(c.column(0), y), dot(c.column(0), z), dot(c.column(1), z)};
  bias.moment = moment;
  bias.force += transpose_times(c, ball.free_turn) + linear * work.drift.linear;
}

/// The inertia of a point, seen from the parent's origin.
/// @param arm  from the parent's origin to the point
template <class Real>
SKYBODY_INLINE ArticulatedInertia<Real> carried(const SymMat3<Real>& linear,
                                                const Vec3<Real>& arm) {
  const Mat3<Real> l = to_mat3(linear);
  const Vec3<Real> x = cross(arm, l.column(0)), y = cross(arm, l.column(1)),
                   z = cross(arm, l.column(2));
  const Mat3<Real> coupling{{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z}};
  const Vec3<Real> r0 = cross(arm, coupling.row(0)), r1 = cross(arm, coupling.row(1)),
                   r2 = cross(arm, coupling.row(2));
  return {{r0.x, r1.y, r2.z, r0.y, r0.z, r1.z}, coupling, linear};
}

/// udot of the joint and the body's acceleration.
/// @param a  in: with the joint's own accelerations zero, about M's origin; out: about O
template <class Real>
SKYBODY_INLINE void follow_ball(const TreeBody& tree, const BodyKinematics<Real>& body,
                                const BallJointCache<Real>& ball, SpatialAcceleration<Real>& a,
                                Real* udot) {
  const Vec3<Real> turn = ball.free_turn - ball.follow * a.linear;
  store(transpose_times(ball.axes, turn - a.angular), udot);
  a.angular = turn;
  if (!tree.plain_body) a.linear += cross(turn, ball.lever) + swing(body, ball);
}

}  // namespace skybody
