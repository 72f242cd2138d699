// What happens within one physics step whoever computes it: how rotors run, how drives set a base's
// coordinates, and the two explicit integration rules. On double and packs.
#pragma once

#include "core/physics/base_drive.h"
#include "core/physics/rotor_lag.h"

namespace skybody {

/// A state beyond this [m, rad, m/s, rad/s] has diverged: it is a thousand kilometres away, or
/// faster than any rotor.
inline constexpr double kLargestState = 1e6;

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
  /// Speed in mid-step, and the change of speed over the step instead of an acceleration: for one
  /// evaluation a step.
  /// @param end  speed at the end of the step
  SKYBODY_INLINE RotorMotion<Real> mean(const Real& end) const {
    return {at(kStepMiddle).speed, end - speed};
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

/// Semi-implicit (symplectic) Euler, order 1: u += dt udot, then q += dt N(q) u. Rotors count with
/// their speed in mid-step.
/// @param state  has change_velocity(rates, time) and change_position(time), by its velocity
/// @param rates  udot at the step's start
template <class State, class Rates>
SKYBODY_INLINE void semi_implicit_euler(double dt, const Rates& rates, State& state) {
  state.change_velocity(rates, dt);
  state.change_position(dt);
}

/// Where the classical Runge-Kutta method keeps its stages.
/// @tparam State  has set(start, rate, time): start + time rate, number by number, where start may
///                be the state itself; and add(rate)
template <class State>
struct RungeKuttaWork {
  State point;               ///< a stage's
  State rate, inner, outer;  ///< a stage's, and sums of those in mid-step and of the others
};

/// The classical Runge-Kutta method, order 4; rotors follow their closed form at the stages' times.
/// @param rates  rates(state, time, rate) writes what the state changes by in a second. It is large
///               code: the loop has it once
/// @param state  at the step's start; written: at its end
template <class State, class Rates>
SKYBODY_INLINE void runge_kutta_4(double dt, const Rates& rates, State& state,
                                  RungeKuttaWork<State>& work) {
  constexpr StageTime kTimes[4] = {kStepStart, kStepMiddle, kStepMiddle, kStepEnd};
  State* const rate[4] = {&work.outer, &work.inner, &work.rate, &work.rate};
#pragma GCC unroll 1
  for (int k = 0; k < 4; ++k) {
    if (k > 0) work.point.set(state, *rate[k - 1], k == 3 ? dt : 0.5 * dt);
    rates(k == 0 ? state : work.point, kTimes[k], *rate[k]);
    if (k == 2) work.inner.add(work.rate);
  }
  work.outer.add(work.rate);
  work.outer.set(work.outer, work.inner, 2.0);
  state.set(state, work.outer, dt / 6.0);
}

}  // namespace skybody
