// What a multirotor must do to have a given acceleration: its attitude, thrust, body rates and
// angular acceleration follow from acceleration, jerk, snap and heading (differential flatness).
//
// With u = a + g e_z the specific thrust, the body's z axis lies along u, and the thrust per mass
// is |u|. Heading first, then the shortest turn of e_z to u:
//   q = t(u) * (cos(yaw/2), 0, 0, sin(yaw/2)),  t = (1 + up_z, -up_y, up_x, 0) / norm,  up = u /
//   |u|
// Rates and angular acceleration are derivatives of q by time, taken by jets:
//   w = 2 vec(q* dq/dt),  dw/dt = 2 vec(q* d2q/dt2)
// Limits: u must not vanish (free fall) nor point straight down; there, the attitude is level with
// rates of 0.
//
// Source: D. Mellinger and V. Kumar, Minimum snap trajectory generation and control for quadrotors,
// ICRA 2011, section III; the turn as in M. Watterson and V. Kumar, Control of quadrotors using the
// Hopf fibration on SO(3), ISRR 2017.
#pragma once

#include <skybody/plugin.h>

#include "controllers/common/robot.h"

namespace skybody::control {

/// Below this [m/s^2], and this close to straight down [share], a thrust has no attitude.
inline constexpr double kLeastThrust = 1e-6;

/// Thrust of all rotors per mass, W axes, with its derivatives by time.
template <class Real>
struct SpecificThrust {
  Vec3<Real> value;   ///< acceleration less gravity [m/s^2]
  Vec3<Real> rate;    ///< [m/s^3]
  Vec3<Real> second;  ///< [m/s^4]
};

/// What it takes of the body.
template <class Real>
struct FlatMotion {
  Real thrust;                      ///< per mass, along z of B [m/s^2]
  Quat<Real> rotation;              ///< W from B
  Vec3<Real> rates;                 ///< B axes [rad/s]
  Vec3<Real> angular_acceleration;  ///< B axes [rad/s^2]
};

/// Heading first, then the shortest turn of e_z to `up`, a unit vector that does not point straight
/// down.
/// @tparam Number  a Real, or a Jet
/// @param half     sine and cosine of half the heading
template <class Number>
SKYBODY_INLINE Quat<Number> tilted(const Vec3<Number>& up, const SinCos<Number>& half) {
  const Quat<Number> tilt = normalized(Quat<Number>{1.0 + up.z, -up.y, up.x, Number(0.0)});
  return tilt * Quat<Number>{half.cos, Number(0.0), Number(0.0), half.sin};
}

/// The motion that belongs to a specific thrust and a heading.
template <class Real>
SKYBODY_INLINE FlatMotion<Real> flat_motion(const SpecificThrust<Real>& u, const Real& yaw,
                                            const Real& yaw_rate) {
  using Number = Jet<Real, 3>;
  const Real size = norm(u.value);
  const auto usable = logical_and(size > kLeastThrust, size + u.value.z > kLeastThrust * size);
  const auto jet = [&](const Real& value, const Real& rate, const Real& second, double instead) {
    Number out;
    out.c[0] = select(usable, value, Real(instead));
    out.c[1] = select(usable, rate, Real(0.0));
    out.c[2] = select(usable, 0.5 * second, Real(0.0));
    return out;
  };
  const Vec3<Number> thrust{jet(u.value.x, u.rate.x, u.second.x, 0.0),
                            jet(u.value.y, u.rate.y, u.second.y, 0.0),
                            jet(u.value.z, u.rate.z, u.second.z, 1.0)};
  const Number inverse = 1.0 / sqrt(squared_norm(thrust));
  const Number half_yaw = Number::variable(0.5 * wrap_angle(yaw), 0.5 * yaw_rate);
  const Quat<Number> q = tilted(thrust * inverse, sincos(half_yaw));
  const auto part = [&](int k) { return Quat<Real>{q.w.c[k], q.x.c[k], q.y.c[k], q.z.c[k]}; };
  const Quat<Real> back = conjugate(part(0));
  const Quat<Real> first = back * part(1), second = back * part(2);
  return {size,
          part(0),
          {2.0 * first.x, 2.0 * first.y, 2.0 * first.z},
          {4.0 * second.x, 4.0 * second.y, 4.0 * second.z}};
}

}  // namespace skybody::control
