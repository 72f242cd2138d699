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

/// Adds one rotor's forces to `sum`, which is about the body's origin like any SpatialForce but in
/// the axes of the body. Effects whose constant is zero cost nothing.
/// @param constants  the rotor's kRotorParamCount values
/// @param direction  +1 or -1
/// @param position, axis         hub [m] and thrust direction, body axes
/// @param velocity, angular_velocity  of the body's origin [m/s] and body [rad/s], body axes
template <class Real, class Constants>
SKYBODY_INLINE void add_rotor_force(const Constants& constants, double direction,
                                    const Vec3<Real>& position, const Vec3<Real>& axis,
                                    const RotorMotion<Real>& rotor, const Vec3<Real>& velocity,
                                    const Vec3<Real>& angular_velocity, SpatialForce<Real>& sum) {
  const Real w = rotor.speed;
  const Real w_squared = w * w;
  Vec3<Real> force = axis * (constants[kThrustConstant] * w_squared);
  Real about_axis = constants[kMomentConstant] * w_squared;
  const Real drag = constants[kDragConstant], rolling = constants[kRollingMomentConstant];
  const Real inertia = constants[kRotorInertia];
  const auto spins_up = inertia != 0.0;
  if (any(spins_up)) {
    about_axis = select(spins_up, about_axis + inertia * rotor.acceleration, about_axis);
  }
  Vec3<Real> moment = axis * about_axis;
  const auto drags = drag != 0.0, rolls = rolling != 0.0;
  if (any(logical_or(drags, rolls))) {
    const Vec3<Real> hub_velocity = velocity + cross(angular_velocity, position);
    const Vec3<Real> across = hub_velocity - axis * dot(hub_velocity, axis);
    force = select(drags, force - across * (drag * w), force);
    moment = select(rolls, moment + across * (rolling * w), moment);
  }
  if (any(spins_up)) {
    moment = select(spins_up, moment + cross(angular_velocity, axis * (inertia * w)), moment);
  }
  sum.add_force_at(position, force);
  sum.moment -= moment * Real(direction);
}

}  // namespace skybody
