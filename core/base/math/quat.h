// Unit quaternions on Real: rotations from the body frame B to the world frame W.
// Order w x y z, Hamilton's product, active rotation: rotate(q, v_B) = v_W.
#pragma once

#include "core/base/math/mat3.h"
#include "core/base/math/math_atan.h"
#include "core/base/math/math_trig.h"
#include "core/base/math/vec3.h"

namespace skybody {

/// w + x i + y j + z k, W from B. Functions below expect unit norm unless stated otherwise.
template <class Real>
struct Quat {
  Real w, x, y, z;

  static SKYBODY_INLINE Quat identity() { return {Real(1.0), Real(0.0), Real(0.0), Real(0.0)}; }

  /// Hamilton's product: rotates by b first, then by a. Any norm.
  friend SKYBODY_INLINE Quat operator*(const Quat& a, const Quat& b) {
    return {((a.w * b.w - a.x * b.x) - a.y * b.y) - a.z * b.z,
            ((a.w * b.x + a.x * b.w) + a.y * b.z) - a.z * b.y,
            ((a.w * b.y - a.x * b.z) + a.y * b.w) + a.z * b.x,
            ((a.w * b.z + a.x * b.y) - a.y * b.x) + a.z * b.w};
  }
};

/// Hamilton's product as a function.
template <class Real>
SKYBODY_INLINE Quat<Real> multiply(const Quat<Real>& a, const Quat<Real>& b) {
  return a * b;
}

/// The inverse rotation, B from W.
template <class Real>
SKYBODY_INLINE Quat<Real> conjugate(const Quat<Real>& q) {
  return {q.w, -q.x, -q.y, -q.z};
}

template <class Real>
SKYBODY_INLINE Real squared_norm(const Quat<Real>& q) {
  return (q.w * q.w + q.x * q.x) + (q.y * q.y + q.z * q.z);
}

/// q / |q|; not finite for the zero quaternion.
template <class Real>
SKYBODY_INLINE Quat<Real> normalized(const Quat<Real>& q) {
  const Real scale = 1.0 / sqrt(squared_norm(q));
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

template <class Real>
SKYBODY_INLINE Quat<Real> select(const MaskOf<Real>& mask, const Quat<Real>& a,
                                 const Quat<Real>& b) {
  return {select(mask, a.w, b.w), select(mask, a.x, b.x), select(mask, a.y, b.y),
          select(mask, a.z, b.z)};
}

/// Whether all four components are finite.
template <class Real>
SKYBODY_INLINE MaskOf<Real> is_finite(const Quat<Real>& q) {
  return logical_and(logical_and(is_finite(q.w), is_finite(q.x)),
                     logical_and(is_finite(q.y), is_finite(q.z)));
}

/// v_W from v_B: v + 2 w (u x v) + 2 u x (u x v), u the vector part.
template <class Real>
SKYBODY_INLINE Vec3<Real> rotate(const Quat<Real>& q, const Vec3<Real>& v) {
  const Vec3<Real> u{q.x, q.y, q.z};
  const Vec3<Real> c = cross(u, v);
  const Vec3<Real> t = c + c;
  return (v + t * q.w) + cross(u, t);
}

/// v_B from v_W.
template <class Real>
SKYBODY_INLINE Vec3<Real> rotate_inverse(const Quat<Real>& q, const Vec3<Real>& v) {
  return rotate(conjugate(q), v);
}

/// The rotation matrix W from B.
template <class Real>
SKYBODY_INLINE Mat3<Real> to_mat3(const Quat<Real>& q) {
  const Real x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const Real xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const Real xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const Real wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  return {{1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx,
           1.0 - (xx + yy)}};
}

/// The third column of to_mat3: the body's z axis in W.
template <class Real>
SKYBODY_INLINE Vec3<Real> body_z(const Quat<Real>& q) {
  const Real x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  return {q.x * z2 + q.w * y2, q.y * z2 - q.w * x2, 1.0 - (q.x * x2 + q.y * y2)};
}

/// Cosine of the tilt: the body's z axis dot the world's, in [-1, 1].
template <class Real>
SKYBODY_INLINE Real tilt_cosine(const Quat<Real>& q) {
  return 1.0 - (q.x * (q.x + q.x) + q.y * (q.y + q.y));
}

/// Heading [rad] in [-pi, pi]: the third fixed-axis angle of from_rpy. Unspecified but finite if
/// the body's x axis points straight up or down.
template <class Real>
SKYBODY_INLINE Real yaw(const Quat<Real>& q) {
  return atan2(2.0 * (q.x * q.y + q.w * q.z), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

/// Fixed-axis roll (x), pitch (y), yaw (z) [rad]; the inverse of from_rpy. Pitch in [-pi/2, pi/2].
template <class Real>
SKYBODY_INLINE Vec3<Real> to_rpy(const Quat<Real>& q) {
  const Real sine = clamp(2.0 * (q.w * q.y - q.x * q.z), Real(-1.0), Real(1.0));
  const Real roll = atan2(2.0 * (q.w * q.x + q.y * q.z), 1.0 - 2.0 * (q.x * q.x + q.y * q.y));
  return {roll, asin(sine), yaw(q)};
}

/// URDF's convention: roll about W's x, then pitch about W's y, then yaw about W's z [rad].
template <class Real>
SKYBODY_INLINE Quat<Real> from_rpy(const Real& roll, const Real& pitch, const Real& yaw) {
  const SinCos<Real> r = sincos(0.5 * roll), p = sincos(0.5 * pitch), y = sincos(0.5 * yaw);
  return {(r.cos * p.cos) * y.cos + (r.sin * p.sin) * y.sin,
          (r.sin * p.cos) * y.cos - (r.cos * p.sin) * y.sin,
          (r.cos * p.sin) * y.cos + (r.sin * p.cos) * y.sin,
          (r.cos * p.cos) * y.sin - (r.sin * p.sin) * y.cos};
}

/// Rotation by `angle` [rad] about a unit axis.
template <class Real>
SKYBODY_INLINE Quat<Real> from_axis_angle(const Vec3<Real>& axis, const Real& angle) {
  const SinCos<Real> half = sincos(0.5 * angle);
  return {half.cos, axis.x * half.sin, axis.y * half.sin, axis.z * half.sin};
}

/// Rotation by |v| [rad] about v; to first order below 1e-9 rad.
template <class Real>
SKYBODY_INLINE Quat<Real> from_rotation_vector(const Vec3<Real>& v) {
  const Real angle = norm(v);
  const SinCos<Real> half = sincos(0.5 * angle);
  const auto small = angle < 1e-9;
  const Real scale = select(small, Real(0.5), half.sin / select(small, Real(1.0), angle));
  return {half.cos, v.x * scale, v.y * scale, v.z * scale};
}

/// From a rotation matrix (orthonormal, determinant 1), with w >= 0 except for round-off.
/// Shepperd (1978): uses the largest of four squares, which avoids cancellation.
template <class Real>
SKYBODY_INLINE Quat<Real> from_rotation(const Mat3<Real>& r) {
  const Real w2 = 1.0 + ((r.m[0] + r.m[4]) + r.m[8]);
  const Real x2 = 1.0 + ((r.m[0] - r.m[4]) - r.m[8]);
  const Real y2 = 1.0 + ((r.m[4] - r.m[0]) - r.m[8]);
  const Real z2 = 1.0 + ((r.m[8] - r.m[0]) - r.m[4]);
  const Real wx = r.m[7] - r.m[5], wy = r.m[2] - r.m[6], wz = r.m[3] - r.m[1];
  const Real xy = r.m[3] + r.m[1], xz = r.m[2] + r.m[6], yz = r.m[7] + r.m[5];
  const Quat<Real> by_w{w2, wx, wy, wz}, by_x{wx, x2, xy, xz};
  const Quat<Real> by_y{wy, xy, y2, yz}, by_z{wz, xz, yz, z2};
  const Quat<Real> wx_best = select(w2 >= x2, by_w, by_x);
  const Quat<Real> yz_best = select(y2 >= z2, by_y, by_z);
  const Quat<Real> best = select(max(w2, x2) >= max(y2, z2), wx_best, yz_best);
  const Quat<Real> q = normalized(best);
  const Quat<Real> opposite{-q.w, -q.x, -q.y, -q.z};
  return select(q.w < 0.0, opposite, q);
}

/// The same quaternion for all lanes.
template <class Real>
SKYBODY_INLINE Quat<Real> to_real(const Quat<double>& q) {
  return {Real(q.w), Real(q.x), Real(q.y), Real(q.z)};
}

}  // namespace skybody
