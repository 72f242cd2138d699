// Positions and velocities of bodies from q and u: forward kinematics over the tree. The same code
// serves double and packs. Simbody's kinematics are not used, so that forces and sensors get the
// same motion with both dynamics. Coordinates of each joint: core/model/robot_model.h, JointType.
#pragma once

#include <type_traits>
#include <vector>

#include "core/base/math/math.h"
#include "core/base/math/quat.h"
#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Position and motion of one body frame, all in W axes.
template <class Real>
struct BodyKinematics {
  Vec3<Real> position;          ///< of the body's origin [m]
  Quat<Real> rotation;          ///< W from B, unit
  Mat3<Real> axes;              ///< the same rotation as a matrix
  Vec3<Real> velocity;          ///< of the origin [m/s]
  Vec3<Real> angular_velocity;  ///< [rad/s]
  Vec3<Real> spin;              ///< the same in the body's own axes [rad/s]
};

/// Motion of a joint's frame M in its frame F.
template <class Real>
struct JointMotion {
  Vec3<Real> translation;       ///< of M's origin, F axes [m]
  Quat<Real> rotation;          ///< F from M, unit
  Vec3<Real> velocity;          ///< of M's origin, F axes [m/s]
  Vec3<Real> angular_velocity;  ///< M axes [rad/s]
};

/// @param p  a pointer to reals, or a view with the same indexing (lane_values.h)
template <class Values>
SKYBODY_INLINE auto load_vec3(const Values& p) {
  return Vec3<std::decay_t<decltype(p[0])>>{p[0], p[1], p[2]};
}
template <class Values>
SKYBODY_INLINE auto load_quat(const Values& p) {
  return Quat<std::decay_t<decltype(p[0])>>{p[0], p[1], p[2], p[3]};
}
template <class Real>
SKYBODY_INLINE void store(const Vec3<Real>& v, Real* p) {
  p[0] = v.x;
  p[1] = v.y;
  p[2] = v.z;
}
template <class Real>
SKYBODY_INLINE void store(const Quat<Real>& q, Real* p) {
  p[0] = q.w;
  p[1] = q.x;
  p[2] = q.y;
  p[3] = q.z;
}

/// The rotation of a quaternion of any norm but zero. Returned unchanged if the norm is 1 up to
/// round-off, so that normalised quaternions at the ends of steps keep their bits.
template <class Real>
SKYBODY_INLINE Quat<Real> as_rotation(const Quat<Real>& q) {
  const auto is_unit =
      abs(squared_norm(q) - 1.0) <= 2e-15;  // 18 roundings; normalized() leaves at most 12
  if (all(is_unit)) return q;
  return select(is_unit, q, normalized(q));
}

/// @param q, u  the joint's own coordinates; the quaternion may have any norm but zero, as between
///              the stages of an integrator
template <class Real>
SKYBODY_INLINE JointMotion<Real> joint_motion(JointType type, const Real* q, const Real* u) {
  const Real zero(0.0), one(1.0);
  JointMotion<Real> m{
      {zero, zero, zero}, {one, zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
  switch (type) {
    case JointType::kWeld:
      break;
    case JointType::kFree:
      m = {load_vec3(q), as_rotation(load_quat(q + 3)), load_vec3(u), load_vec3(u + 3)};
      break;
    case JointType::kPin: {
      const SinCos<Real> half = sincos(0.5 * q[0]);
      m.rotation = {half.cos, zero, zero, half.sin};
      m.angular_velocity.z = u[0];
      break;
    }
    case JointType::kSlider:
      m.translation.x = q[0];
      m.velocity.x = u[0];
      break;
    case JointType::kUniversal: {
      // About x, then about the new y: in M axes the first rate lies along R_y^T x.
      const SinCos<Real> x = sincos(0.5 * q[0]), y = sincos(0.5 * q[1]);
      const SinCos<Real> full{2.0 * y.sin * y.cos, 1.0 - 2.0 * y.sin * y.sin};
      m.rotation = {x.cos * y.cos, x.sin * y.cos, x.cos * y.sin, x.sin * y.sin};
      m.angular_velocity = {full.cos * u[0], u[1], full.sin * u[0]};
      break;
    }
    case JointType::kBall:
      m.rotation = as_rotation(load_quat(q));
      m.angular_velocity = load_vec3(u);
      break;
  }
  return m;
}

/// dq/dt times `time`, for dq/dt = q (0, w) / 2 (paper eq. 1).
/// @param w  in the axes that q rotates from
template <class Real>
SKYBODY_INLINE Quat<Real> quaternion_change(const Quat<Real>& q, const Vec3<Real>& w, double time) {
  const double half = 0.5 * time;
  return {
      -half * ((q.x * w.x + q.y * w.y) + q.z * w.z), half * ((q.w * w.x + q.y * w.z) - q.z * w.y),
      half * ((q.w * w.y + q.z * w.x) - q.x * w.z), half * ((q.w * w.z + q.x * w.y) - q.y * w.x)};
}

/// The rotation q after `time` at constant w: q exp(w time / 2). Sine and cosine are series, exact
/// to 3e-11 up to |w| time = 0.1, and so is the norm.
/// @param time  one for all lanes, or one per lane
template <class Real, class Time>
SKYBODY_INLINE Quat<Real> turned(const Quat<Real>& q, const Vec3<Real>& w, const Time& time) {
  const Vec3<Real> half = w * Real(0.5 * time);
  const Real square = dot(half, half);
  const Vec3<Real> v = half * (1.0 - square * (1.0 / 6 - square * (1.0 / 120)));  // sine
  const Real c = 1.0 - square * (0.5 - square * (1.0 / 24));                      // cosine
  return {c * q.w - ((q.x * v.x + q.y * v.y) + q.z * v.z),
          c * q.x + ((q.w * v.x + q.y * v.z) - q.z * v.y),
          c * q.y + ((q.w * v.y + q.z * v.x) - q.x * v.z),
          c * q.z + ((q.w * v.z + q.x * v.y) - q.y * v.x)};
}

/// The same except for the norm, which grows to 1 + |w time|^2 / 8 and more. Uses the tangent of
/// half the angle instead of sine and cosine: a series exact to 1e-9 up to |w| time = 0.1.
template <class Real>
SKYBODY_INLINE Quat<Real> integrate_rotation_unnormalized(const Quat<Real>& q, const Vec3<Real>& w,
                                                          double time) {
  const Vec3<Real> half = w * Real(0.5 * time);
  const Real square = dot(half, half);
  const Vec3<Real> v = half * (1.0 + square * (1.0 / 3 + square * (2.0 / 15)));
  return {q.w - ((q.x * v.x + q.y * v.y) + q.z * v.z), q.x + ((q.w * v.x + q.y * v.z) - q.z * v.y),
          q.y + ((q.w * v.y + q.z * v.x) - q.x * v.z), q.z + ((q.w * v.z + q.x * v.y) - q.y * v.x)};
}

/// One joint's coordinates after `time` at constant u, by turned().
template <class Real, class Time>
SKYBODY_INLINE void drift_position(JointType type, const Time& time, const Real* u, Real* q) {
  if (type == JointType::kBall) {
    store(turned(load_quat(q), load_vec3(u), time), q);
    return;
  }
  const bool is_free = type == JointType::kFree;
  for (int i = 0; i < (is_free ? 3 : velocity_size(type)); ++i) q[i] += time * u[i];
  if (is_free) store(turned(load_quat(q + 3), load_vec3(u + 3), time), q + 3);
}

/// dq/dt of one joint.
template <class Real>
SKYBODY_INLINE void position_rates(JointType type, const Real* q, const Real* u, Real* qdot) {
  if (type == JointType::kFree) {
    for (int i = 0; i < 3; ++i) qdot[i] = u[i];
    store(quaternion_change(load_quat(q + 3), load_vec3(u + 3), 1.0), qdot + 3);
  } else if (type == JointType::kBall) {
    store(quaternion_change(load_quat(q), load_vec3(u), 1.0), qdot);
  } else {
    for (int i = 0; i < velocity_size(type); ++i) qdot[i] = u[i];
  }
}

/// q / |q| for a quaternion whose norm a step has changed slightly.
/// @param squared  its squared norm
template <class Real>
SKYBODY_INLINE Quat<Real> renormalized(const Quat<Real>& q, const Real& squared) {
  const Real d = squared - 1.0;
  const Real d2 = d * d;  // in pairs: the terms are independent
  Real scale = (1.0 - 0.5 * d) + d2 * ((0.375 - 0.3125 * d) + 0.2734375 * d2);
  const auto is_small = abs(d) < 1e-3;
  if (!all(is_small)) scale = select(is_small, scale, 1.0 / sqrt(squared));
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

/// Normalises the joint's quaternion, if any, after a step.
template <class Real>
SKYBODY_INLINE void normalize_position(JointType type, Real* q) {
  if (type != JointType::kFree && type != JointType::kBall) return;
  Real* place = type == JointType::kFree ? q + 3 : q;
  const Quat<Real> rotation = load_quat(place);
  store(renormalized(rotation, squared_norm(rotation)), place);
}

/// Normalises the joint's quaternion, if any; its norm may be any but zero.
template <class Real>
SKYBODY_INLINE void make_unit(JointType type, Real* q) {
  if (type == JointType::kFree) store(as_rotation(load_quat(q + 3)), q + 3);
  if (type == JointType::kBall) store(as_rotation(load_quat(q)), q);
}

/// One body of the tree. Frames that coincide are skipped in the computations.
struct TreeBody {
  JointType type = JointType::kFree;
  int parent = -1;
  int q = 0, u = 0;
  bool plain_parent = true;  ///< F is the parent's own frame
  bool level_parent = true;  ///< F's axes are the parent's
  bool plain_body = true;    ///< M is the body's own frame
  Pose frame_in_parent;      ///< X_PF
  Pose frame_in_body;        ///< X_BM
};

/// The world's bodies, parents before children.
std::vector<TreeBody> make_tree(const World& world);

/// The motion of a joint's frame F, which is fixed to the parent (or to W).
template <class Real>
SKYBODY_INLINE BodyKinematics<Real> frame_on_parent(const TreeBody& body,
                                                    const BodyKinematics<Real>* bodies) {
  const Real zero(0.0);
  BodyKinematics<Real> frame;
  if (body.parent < 0) {
    frame.position = to_real<Real>(body.frame_in_parent.position);
    frame.rotation = to_real<Real>(body.frame_in_parent.rotation);
    frame.axes = to_mat3(frame.rotation);
    frame.velocity = frame.angular_velocity = frame.spin = {zero, zero, zero};
    return frame;
  }
  frame = bodies[body.parent];
  if (body.plain_parent) return frame;
  const Vec3<Real> arm = frame.axes * to_real<Real>(body.frame_in_parent.position);
  frame.position += arm;
  frame.velocity += cross(frame.angular_velocity, arm);
  if (body.level_parent) return frame;
  frame.rotation = frame.rotation * to_real<Real>(body.frame_in_parent.rotation);
  frame.axes = to_mat3(frame.rotation);
  return frame;
}

/// The axes of the joint's frame F in W.
template <class Real>
SKYBODY_INLINE Mat3<Real> frame_axes(const TreeBody& body, const BodyKinematics<Real>* bodies) {
  if (body.parent < 0) return to_mat3(to_real<Real>(body.frame_in_parent.rotation));
  const BodyKinematics<Real>& parent = bodies[body.parent];
  if (body.level_parent) return parent.axes;
  return to_mat3(parent.rotation * to_real<Real>(body.frame_in_parent.rotation));
}

/// The motion of a joint's frame M from that of its frame F.
template <class Real>
SKYBODY_INLINE void attach(JointType type, const BodyKinematics<Real>& frame,
                           const JointMotion<Real>& joint, BodyKinematics<Real>& b) {
  b.position = frame.position;
  b.velocity = frame.velocity;
  if (type == JointType::kFree || type == JointType::kSlider) {
    const Vec3<Real> travel = frame.axes * joint.translation;
    b.position += travel;
    b.velocity += cross(frame.angular_velocity, travel);
    b.velocity += frame.axes * joint.velocity;
  }
  b.rotation = frame.rotation * joint.rotation;
  b.axes = to_mat3(b.rotation);
  b.angular_velocity = frame.angular_velocity + b.axes * joint.angular_velocity;
}

/// Converts the motion of the joint's frame M to that of the body's own frame: B from M is the
/// inverse of X_BM.
template <class Real>
SKYBODY_INLINE void to_body_frame(const TreeBody& body, BodyKinematics<Real>& b) {
  b.rotation = b.rotation * conjugate(to_real<Real>(body.frame_in_body.rotation));
  b.axes = to_mat3(b.rotation);
  const Vec3<Real> arm = b.axes * to_real<Real>(body.frame_in_body.position);
  b.position -= arm;
  b.velocity -= cross(b.angular_velocity, arm);
}

/// Motion of the bodies [first, last) in the order of `tree`. They must not depend on bodies
/// outside this range.
template <class Real>
SKYBODY_INLINE void forward_kinematics(const std::vector<TreeBody>& tree, int first, int last,
                                       const Real* q, const Real* u, BodyKinematics<Real>* bodies) {
  for (int i = first; i < last; ++i) {
    const TreeBody& body = tree[static_cast<std::size_t>(i)];
    const JointMotion<Real> joint = joint_motion(body.type, q + body.q, u + body.u);
    BodyKinematics<Real>& b = bodies[i];
    if (body.parent < 0 && body.plain_parent) {
      b.position = joint.translation;
      b.rotation = joint.rotation;
      b.axes = to_mat3(b.rotation);
      b.velocity = joint.velocity;
      b.angular_velocity = b.axes * joint.angular_velocity;
      b.spin = joint.angular_velocity;
      if (body.plain_body) continue;
    } else if (body.plain_parent) {
      attach(body.type, bodies[body.parent], joint, b);
    } else {
      attach(body.type, frame_on_parent(body, bodies), joint, b);
    }
    if (!body.plain_body) to_body_frame(body, b);
    b.spin = transpose_times(b.axes, b.angular_velocity);
  }
}

/// Motion of all bodies.
template <class Real>
SKYBODY_INLINE void forward_kinematics(const std::vector<TreeBody>& tree, const Real* q,
                                       const Real* u, BodyKinematics<Real>* bodies) {
  forward_kinematics(tree, 0, static_cast<int>(tree.size()), q, u, bodies);
}

/// The same motion in the form for sensors and plugins: angular velocity in the body's axes.
SKYBODY_INLINE BodyState to_body_state(const BodyKinematics<double>& b) {
  return {b.position, b.rotation, b.velocity, b.spin};
}

}  // namespace skybody
