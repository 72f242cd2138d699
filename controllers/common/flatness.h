// Differential flatness: a multirotor's attitude, thrust, body rates and angular acceleration from
// acceleration, jerk, snap and heading.
//
// With the specific thrust u = a + g e_z, the body's z axis lies along u, and the thrust per mass
// is |u|. The attitude is the heading, followed by the shortest rotation of e_z to s = u / |u|:
//   q = t(s) * (cos(yaw/2), 0, 0, sin(yaw/2)),  t = (1 + s_z, -s_y, s_x, 0) / norm
// With k = 1 / (1 + s_z) and r = k ds_z/dt, the rates of t in its own axes are:
//   w_t = (r s_y - ds_y, ds_x - r s_x, k (s_y ds_x - s_x ds_y))
// The body's rates are w_t, rotated back by the heading, plus the heading's rate about z. Its
// angular acceleration is their derivative.
// Limits: if u vanishes (free fall) or points straight down, the attitude is level and only the
// heading turns. The yaw rate is taken as constant.
//
// Source: D. Mellinger and V. Kumar, Minimum snap trajectory generation and control for quadrotors,
// ICRA 2011, section III; the rotation t and its rates as in M. Watterson and V. Kumar, Control of
// quadrotors using the Hopf fibration on SO(3), ISRR 2017, section 4. tests/unit/controllers
// compares them with derivatives of q by jets.
#pragma once

#include <skybody/plugin.h>

#include "controllers/common/robot.h"

namespace skybody::control {

/// Least thrust [m/s^2] and least relative distance from straight down with a defined attitude.
inline constexpr double kLeastThrust = 1e-6;

/// Thrust of all rotors per mass, W axes, with its time derivatives.
template <class Real>
struct SpecificThrust {
  Vec3<Real> value;   ///< acceleration less gravity [m/s^2]
  Vec3<Real> rate;    ///< [m/s^3]
  Vec3<Real> second;  ///< [m/s^4]
};

/// A body's thrust, attitude, rates and angular acceleration for a given acceleration.
template <class Real>
struct FlatMotion {
  Real thrust;                      ///< per mass, along z of B [m/s^2]
  Quat<Real> rotation;              ///< W from B
  Vec3<Real> rates;                 ///< B axes [rad/s]
  Vec3<Real> angular_acceleration;  ///< B axes [rad/s^2]
};

/// Attitude: the heading, followed by the shortest rotation of e_z to `up`, a unit vector that does
/// not point straight down.
/// @tparam Number  a Real, or a Jet
/// @param half     sine and cosine of half the heading
template <class Number>
SKYBODY_INLINE Quat<Number> tilted(const Vec3<Number>& up, const SinCos<Number>& half) {
  const Quat<Number> tilt = normalized(Quat<Number>{1.0 + up.z, -up.y, up.x, Number(0.0)});
  return tilt * Quat<Number>{half.cos, Number(0.0), Number(0.0), half.sin};
}

/// The attitude for a specific thrust and a heading.
template <class Real>
struct FlatAttitude {
  Real thrust;          ///< per mass, along z of B [m/s^2]
  Quat<Real> rotation;  ///< W from B
  Vec3<Real> up;        ///< s: z of B in W axes
  Real inverse;         ///< 1 / thrust; 0 if the attitude is undefined [s^2/m]
  Real fold;            ///< k = 1 / (1 + s_z)
  SinCos<Real> half;    ///< of half the heading

  /// Rotates v from axes before the heading to axes of B.
  SKYBODY_INLINE Vec3<Real> by_heading(const Vec3<Real>& v) const {
    const Real sine = 2.0 * (half.sin * half.cos), cosine = 1.0 - 2.0 * (half.sin * half.sin);
    return {cosine * v.x + sine * v.y, cosine * v.y - sine * v.x, v.z};
  }
};

/// The body rates for a changing specific thrust.
template <class Real>
struct FlatRates {
  Vec3<Real> value;  ///< B axes [rad/s]
  Vec3<Real> turn;   ///< ds/dt, W axes [1/s]
  Real growth;       ///< derivative of the thrust's magnitude: s . du/dt [m/s^3]
  Real lean;         ///< r = k ds_z/dt [rad/s]
  Real twist;        ///< rate of the rotation t about its own z [rad/s]
};

/// @param thrust  per mass, W axes [m/s^2]
/// @param yaw     heading [rad]
template <class Real>
SKYBODY_INLINE FlatAttitude<Real> flat_attitude(const Vec3<Real>& thrust, const Real& yaw) {
  FlatAttitude<Real> flat;
  flat.thrust = norm(thrust);
  const auto usable =
      logical_and(flat.thrust > kLeastThrust, flat.thrust + thrust.z > kLeastThrust * flat.thrust);
  flat.inverse = select(usable, 1.0 / select(usable, flat.thrust, Real(1.0)), Real(0.0));
  flat.up = select(usable, thrust * flat.inverse, Vec3<Real>{Real(0.0), Real(0.0), Real(1.0)});
  const Real one_up = 1.0 + flat.up.z;
  const Real scale = 1.0 / sqrt(2.0 * one_up);  // 1 / norm of (1 + s_z, -s_y, s_x, 0)
  flat.fold = 2.0 * (scale * scale);
  flat.half = sincos(0.5 * yaw);  // a full turn gives -q, the same rotation
  const Real w = one_up * scale, x = -(flat.up.y * scale), y = flat.up.x * scale;
  const SinCos<Real>& h = flat.half;
  flat.rotation = {w * h.cos, x * h.cos + y * h.sin, y * h.cos - x * h.sin, w * h.sin};
  return flat;
}

/// @param rate      of the specific thrust, W axes [m/s^3]
/// @param yaw_rate  [rad/s]
template <class Real>
SKYBODY_INLINE FlatRates<Real> flat_rates(const FlatAttitude<Real>& flat, const Vec3<Real>& rate,
                                          const Real& yaw_rate) {
  FlatRates<Real> out;
  out.growth = dot(flat.up, rate);
  out.turn = (rate - flat.up * out.growth) * flat.inverse;
  out.lean = out.turn.z * flat.fold;
  out.twist = (flat.up.y * out.turn.x - flat.up.x * out.turn.y) * flat.fold;
  out.value = flat.by_heading(
      {out.lean * flat.up.y - out.turn.y, out.turn.x - out.lean * flat.up.x, out.twist + yaw_rate});
  return out;
}

/// Angular acceleration, B axes [rad/s^2].
/// @param rate, second  derivatives of the specific thrust, W axes [m/s^3, m/s^4]
template <class Real>
SKYBODY_INLINE Vec3<Real> flat_acceleration(const FlatAttitude<Real>& flat,
                                            const FlatRates<Real>& rates, const Vec3<Real>& rate,
                                            const Vec3<Real>& second, const Real& yaw_rate) {
  const Real growth = dot(rates.turn, rate) + dot(flat.up, second);
  const Vec3<Real> bend =
      ((second - flat.up * growth) - rates.turn * (2.0 * rates.growth)) * flat.inverse;
  const Real lean = bend.z * flat.fold - rates.lean * rates.lean;
  const Vec3<Real> turned = flat.by_heading(
      {(rates.lean * rates.turn.y + lean * flat.up.y) - bend.y,
       (bend.x - rates.lean * rates.turn.x) - lean * flat.up.x,
       (flat.up.y * bend.x - flat.up.x * bend.y) * flat.fold - rates.twist * rates.lean});
  return {turned.x + yaw_rate * rates.value.y, turned.y - yaw_rate * rates.value.x, turned.z};
}

/// The motion for a specific thrust and a heading.
template <class Real>
SKYBODY_INLINE FlatMotion<Real> flat_motion(const SpecificThrust<Real>& u, const Real& yaw,
                                            const Real& yaw_rate) {
  const FlatAttitude<Real> flat = flat_attitude(u.value, yaw);
  const FlatRates<Real> rates = flat_rates(flat, u.rate, yaw_rate);
  return {flat.thrust, flat.rotation, rates.value,
          flat_acceleration(flat, rates, u.rate, u.second, yaw_rate)};
}

}  // namespace skybody::control
