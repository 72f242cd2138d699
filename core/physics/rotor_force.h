// What a spinning rotor does to its body. F. Furrer, M. Burri, M. Achtelik, R. Siegwart, "RotorS -
// A modular Gazebo MAV simulator framework", 2016, section "Rotor dynamics", after P. Martin and E.
// Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA 2010. Collective
// thrust and torque of paper eq. 1 are the sums over a robot's rotors.
//
// With w >= 0 the speed, n the axis, s = +1 for counter-clockwise about n, and v' the hub's
// velocity across the axis (still air):
//   thrust            F = k_f w^2 n
//   reaction          M = -s k_m w^2 n
//   rotor drag        F = -c_d w v'
//   rolling moment    M = -s c_r w v'    (RotorS' code leaves out s; which side the advancing
//                                         blade is on, so the sign, goes with the direction)
//   gyroscopic        M = -omega x (s J w n)
//   spin-up           M = -s J (dw/dt) n
// The last two vanish for rotor inertia J = 0.
#pragma once

#include "core/base/vec3.h"
#include "core/model/layout.h"
#include "core/physics/rotor_lag.h"
#include "core/physics/spatial_force.h"

namespace skybody {

/// A rotor on its body.
struct RotorPlace {
  Vec3<double> position, axis;  ///< hub [m] and thrust direction, body axes
  double direction = 1.0;       ///< +1 or -1
  bool is_upright = false;      ///< `axis` is the body's z: then half of the products are zeros
  int params = 0;               ///< first of its kRotorParamCount values
};

namespace rotor_detail {

/// Part of the hub's velocity across the axis.
template <class Real>
SKYBODY_INLINE Vec3<Real> across(const RotorPlace& place, const Vec3<Real>& position,
                                 const Vec3<Real>& velocity, const Vec3<Real>& spin) {
  if (place.is_upright) {
    return {velocity.x + (spin.y * position.z - spin.z * position.y),
            velocity.y + (spin.z * position.x - spin.x * position.z), Real(0.0)};
  }
  const Vec3<Real> axis = to_real<Real>(place.axis);
  const Vec3<Real> hub = velocity + cross(spin, position);
  return hub - axis * dot(hub, axis);
}

/// axis times x, plus other times y.
template <class Real>
SKYBODY_INLINE Vec3<Real> combine(const RotorPlace& place, const Real& x, const Vec3<Real>& other,
                                  const Real& y) {
  if (place.is_upright) return {other.x * y, other.y * y, x};
  return to_real<Real>(place.axis) * x + other * y;
}

/// spin x (axis times x)
template <class Real>
SKYBODY_INLINE Vec3<Real> gyroscopic(const RotorPlace& place, const Vec3<Real>& spin,
                                     const Real& x) {
  if (place.is_upright) return {spin.y * x, -(spin.x * x), Real(0.0)};
  return cross(spin, to_real<Real>(place.axis) * x);
}

}  // namespace rotor_detail

/// Adds one rotor's forces to `sum`, which is about the body's origin like any SpatialForce but in
/// the axes of the body. Effects whose constant is zero cost nothing.
/// @param constants  the rotor's kRotorParamCount values
/// @param velocity, spin  of the body's origin [m/s] and body [rad/s], body axes
template <class Real, class Constants>
SKYBODY_INLINE void add_rotor_force(const Constants& constants, const RotorPlace& place,
                                    const RotorMotion<Real>& rotor, const Vec3<Real>& velocity,
                                    const Vec3<Real>& spin, SpatialForce<Real>& sum) {
  const Vec3<Real> position = to_real<Real>(place.position);
  const Real w = rotor.speed;
  const Real w_squared = w * w;
  const Real thrust = constants[kThrustConstant] * w_squared;
  Real about_axis = constants[kMomentConstant] * w_squared;
  const Real drag = constants[kDragConstant], rolling = constants[kRollingMomentConstant];
  const Real inertia = constants[kRotorInertia];
  const auto spins_up = inertia != 0.0, moves_air = logical_or(drag != 0.0, rolling != 0.0);
  if (any(spins_up)) {
    about_axis = select(spins_up, about_axis + inertia * rotor.acceleration, about_axis);
  }
  const Real zero(0.0);
  Vec3<Real> across{zero, zero, zero};
  if (any(moves_air)) {  // lanes without are left as they would be alone
    across = select(moves_air, rotor_detail::across(place, position, velocity, spin), across);
  }
  const Vec3<Real> force = rotor_detail::combine(place, thrust, across, -(drag * w));
  Vec3<Real> moment = rotor_detail::combine(place, about_axis, across, rolling * w);
  if (any(spins_up)) {
    moment = select(spins_up, moment + rotor_detail::gyroscopic(place, spin, inertia * w), moment);
  }
  sum.add_force_at(position, force);
  if (place.direction > 0.0) {
    sum.moment -= moment;
  } else {
    sum.moment += moment;
  }
}

}  // namespace skybody
