// Rotor effects: force and torque on the base per newton of rotor thrust, and the largest force and
// torque of all rotors together.
//
// Rotor i at r_i pushes with f_i along a_i and gives
//   F_z = a_iz f_i,   tau = ((r_i - c) x a_i - d_i (km_i / kf_i) a_i) f_i,
// with c the base's centre of mass and d_i its direction of rotation. Nominal values, in the frame
// of the base; rotors behind joints are at their initial places.
#pragma once

#include "controllers/common/robot.h"

namespace skybody::control {

/// Thrust along z [N] and torque [N m] of one newton of one rotor, base axes.
struct RotorEffect {
  double thrust;
  Vec3<double> torque;
};

/// @param centre  reference point of the torque, frame of the base [m]
inline RotorEffect effect_about(const RotorInfo& rotor, const Vec3<double>& centre) {
  const Vec3<double> axis = vec3(rotor.axis_in_base);
  const Vec3<double> arm = vec3(rotor.position_in_base) - centre;
  const double reaction = -rotor.direction * rotor.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] /
                          rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
  return {axis.z, cross(arm, axis) + axis * reaction};
}

inline RotorEffect effect_of(const RotorInfo& rotor, const BodyInfo& base) {
  return effect_about(rotor, vec3(base.com));
}

/// Limits of the rotors together: sum of full thrusts along z, and per axis the torque that is
/// reachable in both directions.
struct ThrustTorqueLimits {
  double thrust = 0.0;                 ///< [N]
  Vec3<double> torque{0.0, 0.0, 0.0};  ///< [N m]
};

inline ThrustTorqueLimits limits_of(const View<RotorInfo>& rotors, const BodyInfo& base) {
  double thrust = 0.0;
  Vec3<double> up{0.0, 0.0, 0.0}, down{0.0, 0.0, 0.0};
  for (const RotorInfo& rotor : rotors) {
    const RotorEffect e = effect_of(rotor, base);
    const double full = full_thrust(rotor), least = least_thrust(rotor);
    thrust += max(0.0, max(e.thrust * full, e.thrust * least));
    const Vec3<double> t = e.torque * full, back = e.torque * least;
    up += {max(0.0, max(t.x, back.x)), max(0.0, max(t.y, back.y)), max(0.0, max(t.z, back.z))};
    down += {max(0.0, -min(t.x, back.x)), max(0.0, -min(t.y, back.y)), max(0.0, -min(t.z, back.z))};
  }
  return {thrust, {min(up.x, down.x), min(up.y, down.y), min(up.z, down.z)}};
}

}  // namespace skybody::control
