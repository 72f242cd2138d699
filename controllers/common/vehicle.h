// Response time of a vehicle's rotors and drag of its rotors, nominal values, for default gains and
// feed-forward.
#pragma once

#include "controllers/common/robot.h"

namespace skybody::control {

/// Mean time constant of a robot's rotors, over rise and fall [s]; 0 without rotors.
inline double mean_lag(const Setup& setup, int robot) {
  const View<RotorInfo> rotors = setup.rotors_of(robot);
  double sum = 0.0;
  for (const RotorInfo& rotor : rotors) {
    sum += 0.5 * (rotor.constants[SKYBODY_ROTOR_TAU_UP] + rotor.constants[SKYBODY_ROTOR_TAU_DOWN]);
  }
  return rotors.size() > 0 ? sum / rotors.size() : 0.0;
}

/// Drag of the lifting rotors across their axes, while they carry the robot in equal parts.
struct HoverDrag {
  double per_mass = 0.0;  ///< force per velocity and mass [1/s]
  double height = 0.0;    ///< height of its point of attack above the base's centre of mass [m]
};

/// A rotor's drag force is drag constant * speed * velocity across its axis, at its hub.
inline HoverDrag hover_drag(const Setup& setup, int robot) {
  const View<RotorInfo> rotors = setup.rotors_of(robot);
  const double mass = total_mass(setup, robot), push = mass * gravity_of(setup);
  const double com = setup.bodies()[base_of(setup, robot)].com[2];
  int lifting = 0;
  for (const RotorInfo& rotor : rotors) lifting += lifts(rotor) ? 1 : 0;
  double sum = 0.0, moment = 0.0;
  for (const RotorInfo& rotor : rotors) {
    const double thrust_constant = rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
    if (!(thrust_constant > 0.0) || !lifts(rotor)) continue;
    const double drag =
        rotor.constants[SKYBODY_ROTOR_DRAG_CONSTANT] * sqrt(push / lifting / thrust_constant);
    sum += drag;
    moment += drag * (rotor.position_in_base[2] - com);
  }
  return {sum / mass, sum > 0.0 ? moment / sum : 0.0};
}

/// Factor on default gains that keeps a loop of rate `bandwidth` stable with the rotors' lag: 1 for
/// quick rotors, else less.
/// @param bandwidth  of the fastest loop with its default gains [rad/s]
inline double lag_share(const Setup& setup, int robot, double bandwidth) {
  // A rate loop of gain k behind a lag tau has the poles of tau s^2 + s + k: k = 0.5 / tau gives a
  // damping ratio of 0.71.
  const double lag = mean_lag(setup, robot);
  return lag > 0.0 ? min(1.0, 0.5 / (lag * bandwidth)) : 1.0;
}

/// A gain times lag_share(). A share of 1 skips the multiplication.
template <class Real>
SKYBODY_INLINE Vec3<Real> shared(const Vec3<Real>& gain, double share) {
  return share == 1.0 ? gain : gain * Real(share);
}

}  // namespace skybody::control
