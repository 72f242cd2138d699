// What happens within one physics step whoever computes it: how rotors run, how drives set a base's
// coordinates, and the two explicit integration rules. On double and packs.
#pragma once

#include "core/physics/base_drive.h"
#include "core/physics/rotor_lag.h"

namespace skybody {

/// A rotor's command during one step, ready to be asked how the rotor runs.
template <class Real>
struct RotorStep {
  RotorLag<Real> lag;
  Real speed;    ///< at the start of the step [rad/s]
  Real command;  ///< held, and what the rotor can do [rad/s]

  /// @param command    as held; @param max_speed  what the rotor can do
  SKYBODY_INLINE RotorStep(const RotorLag<Real>& l, const Real& start, const Real& held,
                           const Real& max_speed)
      : lag(l), speed(start), command(limit_command(held, max_speed)) {}

  SKYBODY_INLINE RotorMotion<Real> at(StageTime time) const {
    return rotor_at(lag, speed, command, time);
  }
  /// Speed in mid-step, mean acceleration: for one evaluation a step.
  /// @param end   speed at the end of the step
  /// @param rate  1/dt [1/s]
  SKYBODY_INLINE RotorMotion<Real> mean(const Real& end, double rate) const {
    return {at(kStepMiddle).speed, (end - speed) * rate};
  }
};

/// Sets the rates of a driven base for the step that begins.
/// @param values  the drive's kDriveSize values
/// @param q, u    the base's own
/// @param target  pose drives: the base's coordinates at the step's end, seven, written
template <class Real>
SKYBODY_INLINE void begin_drive(DriveKind kind, const BodyKinematics<Real>& base,
                                const Real* values, double dt, const Real* q, Real* u,
                                Real* target) {
  if (kind == DriveKind::kVelocity) {
    drive_velocity(base, values, u);
    return;
  }
  store(load_vec3(values + kDrivePosition), target);
  store(normalized(load_quat(values + kDriveRotation)), target + 3);
  drive_to_pose(q, target, dt, u);
}

/// Semi-implicit (symplectic) Euler, order 1: u += dt udot(q, u), then q += dt N(q) u. Rotors count
/// with their speed in mid-step.
/// @param mechanics  has mean_accelerations(q, u, udot) and position_rates(q, u, qdot)
template <class Real, class Mechanics>
SKYBODY_INLINE void semi_implicit_euler(Mechanics& mechanics, double dt, int q_count, int u_count,
                                        Real* q, Real* u, Real* qdot, Real* udot) {
  mechanics.mean_accelerations(q, u, udot);
  for (int i = 0; i < u_count; ++i) u[i] += dt * udot[i];
  mechanics.position_rates(q, u, qdot);
  for (int i = 0; i < q_count; ++i) q[i] += dt * qdot[i];
}

/// Where the classical Runge-Kutta method keeps its stages.
template <class Real>
struct StageArrays {
  Real *q = nullptr, *u = nullptr;    ///< a stage's point
  Real *qdot[4] = {}, *udot[4] = {};  ///< its rates
};

/// The classical Runge-Kutta method, order 4; rotors follow their closed form at the stages' times.
/// @param mechanics  has accelerations(q, u, time, udot) and position_rates(q, u, qdot)
template <class Real, class Mechanics>
SKYBODY_INLINE void runge_kutta_4(Mechanics& mechanics, double dt, int q_count, int u_count,
                                  Real* q, Real* u, const StageArrays<Real>& stage) {
  constexpr StageTime kTimes[4] = {kStepStart, kStepMiddle, kStepMiddle, kStepEnd};
  for (int k = 0; k < 4; ++k) {
    const Real *at_q = q, *at_u = u;
    if (k > 0) {
      const double h = k == 3 ? dt : 0.5 * dt;
      for (int i = 0; i < q_count; ++i) stage.q[i] = q[i] + h * stage.qdot[k - 1][i];
      for (int i = 0; i < u_count; ++i) stage.u[i] = u[i] + h * stage.udot[k - 1][i];
      at_q = stage.q;
      at_u = stage.u;
    }
    mechanics.accelerations(at_q, at_u, kTimes[k], stage.udot[k]);
    mechanics.position_rates(at_q, at_u, stage.qdot[k]);
  }
  const auto combine = [&](Real* const(&k)[4], int count, Real* x) {
    for (int i = 0; i < count; ++i) {
      x[i] += (dt / 6.0) * ((k[0][i] + k[3][i]) + 2.0 * (k[1][i] + k[2][i]));
    }
  };
  combine(stage.qdot, q_count, q);
  combine(stage.udot, u_count, u);
}

}  // namespace skybody
