// The force and torque that a rotor's thrust exerts on the base, per newton, and the largest force
// and torque of all rotors together.
//
// Needs: rotors fixed to the base. Rotor i at r_i pushes f_i along a_i and gives
//   F_z = a_iz f_i,   tau = ((r_i - c) x a_i - d_i (km_i / kf_i) a_i) f_i,
// c the base's centre of mass, d_i its sense of rotation. Nominal values.
#pragma once

#include "controllers/common/robot.h"

namespace skybody::control {

/// Thrust along z [N] and torque [N m] of one newton of one rotor, base axes.
struct RotorEffect {
  double thrust;
  Vec3<double> torque;
};

inline RotorEffect effect_of(const RotorInfo& rotor, const BodyInfo& base) {
  const Vec3<double> axis = vec3(rotor.axis);
  const Vec3<double> arm = vec3(rotor.position) - vec3(base.com);
  const double reaction = -rotor.direction * rotor.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] /
                          rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
  return {axis.z, cross(arm, axis) + axis * reaction};
}

/// What the rotors can do together: sum of full thrusts along z, and per axis the torque that is
/// reachable in both senses.
struct ThrustTorqueLimits {
  double thrust = 0.0;                 ///< [N]
  Vec3<double> torque{0.0, 0.0, 0.0};  ///< [N m]
};

inline ThrustTorqueLimits limits_of(const View<RotorInfo>& rotors, const BodyInfo& base) {
  double thrust = 0.0;
  Vec3<double> up{0.0, 0.0, 0.0}, down{0.0, 0.0, 0.0};
  for (const RotorInfo& rotor : rotors) {
    const RotorEffect e = effect_of(rotor, base);
    const double full = full_thrust(rotor);
    thrust += max(0.0, e.thrust * full);
    const Vec3<double> t = e.torque * full;
    up += {max(0.0, t.x), max(0.0, t.y), max(0.0, t.z)};
    down += {max(0.0, -t.x), max(0.0, -t.y), max(0.0, -t.z)};
  }
  return {thrust, {min(up.x, down.x), min(up.y, down.y), min(up.z, down.z)}};
}

}  // namespace skybody::control
