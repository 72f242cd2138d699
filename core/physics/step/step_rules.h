// What happens within one physics step whoever computes it: how rotors run, how drives set a base's
// coordinates, and the explicit integration rules. On double and packs.
#pragma once

#include "core/physics/forces/base_drive.h"
#include "core/physics/forces/rotor_lag.h"

namespace skybody {

/// A state beyond this [m, rad, m/s, rad/s] has diverged: it is a thousand kilometres away, or
/// faster than any rotor.
inline constexpr double kLargestState = 1e6;

/// Where the square of a body's spin [rad^2/s^2] is larger, rules with one evaluation in mid-step
/// move it by its torque-free motion (bodies/torque_free.h), and forces alone change its
/// velocities.
///
/// Below, midpoint takes the body's own gyroscopic torque explicitly: of a wobble, whose frequency
/// is at most the spin w, the energy grows by (w dt)^4 / 4 a step, which is here 1 % a minute at
/// most (29 rad/s at 1 ms, 10 rad/s at 4 ms).
SKYBODY_INLINE double fast_spin_square(double dt) {
  constexpr double kGrowth = 0.01 / 60.0;  // of energy [1/s]
  return sqrt(4.0 * kGrowth / (dt * dt * dt));
}

/// A rotor's command during one step, ready to be asked how the rotor runs.
template <class Real>
struct RotorStep {
  RotorLag<Real> lag;
  Real speed;    ///< at the start of the step [rad/s]
  Real command;  ///< held, and what the rotor can do [rad/s]

  /// @param command  as held; @param max_speed, min_speed  what the rotor can do
  SKYBODY_INLINE RotorStep(const RotorLag<Real>& l, const Real& start, const Real& held,
                           const Real& max_speed, const Real& min_speed = Real(0.0))
      : lag(l), speed(start), command(limit_command(held, max_speed, min_speed)) {}

  SKYBODY_INLINE RotorMotion<Real> at(StageTime time) const {
    return rotor_at(lag, speed, command, time);
  }
  /// Speed in mid-step, and the change of speed over the step instead of an acceleration.
  /// @param end  speed at the end of the step
  SKYBODY_INLINE RotorMotion<Real> in_middle(const Real& end) const {
    return rotor_motion<Real>(at(kStepMiddle).speed, end - speed);
  }
  /// Means over the step, with the change of speed likewise.
  SKYBODY_INLINE RotorMotion<Real> mean(const Real& end) const {
    return rotor_over_step(lag, speed, command, end);
  }
  /// Mean of w |w|. @param square  mean of w^2
  SKYBODY_INLINE Real mean_signed_square(const Real& end, const Real& square) const {
    return skybody::mean_signed_square(lag, speed, command, end, square);
  }
  /// For integrators that choose their own instants: see rotor_at_time.
  template <class Constants>
  RotorMotion<double> at_time(const Constants& constants, double time, double dt) const {
    return rotor_at_time(constants, speed, command, time, dt);
  }
};

/// A rotor that may turn backwards: its squares have a sign.
/// @tparam Step  RotorStep or HeldRotorStep, with a lag_by_size()
template <class Real, class Step>
struct ReversibleRotorStep {
  Step step;

  SKYBODY_INLINE RotorMotion<Real> at(StageTime time) const { return with_sign(step.at(time)); }
  SKYBODY_INLINE RotorMotion<Real> in_middle(const Real& end) const {
    return with_sign(step.in_middle(end));
  }
  SKYBODY_INLINE RotorMotion<Real> mean(const Real& end) const {
    RotorMotion<Real> motion = step.mean(end);
    motion.squared = step.mean_signed_square(end, motion.squared);
    return motion;
  }
  template <class Constants>
  RotorMotion<double> at_time(const Constants& constants, double time, double dt) const {
    const RotorMotion<double> motion = step.at_time(constants, time, dt);
    return {motion.speed, motion.acceleration, motion.speed * abs(motion.speed)};
  }

 private:
  static SKYBODY_INLINE RotorMotion<Real> with_sign(const RotorMotion<Real>& motion) {
    return {motion.speed, motion.acceleration, motion.speed * abs(motion.speed)};
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

/// An explicit one-step rule as its stages: where each evaluates the rates.
struct StepRule {
  IntegratorChoice integrator;
  int stages;
  StageTime time[4];  ///< of the rotors
  double reach[4];    ///< from the step's start with the rates of the stage before [dt]

  /// Whether only velocities are changed by rates, coordinates by velocities.
  constexpr bool is_split() const { return integrator != IntegratorChoice::kRk4; }
};
/// Half a step of the coordinates at the velocities of the start, a step of the velocities by the
/// explicit midpoint rule at those coordinates, half a step of the coordinates at the velocities of
/// the end: order 2. Where forces depend on coordinates alone this is the leapfrog (E. Hairer, C.
/// Lubich, G. Wanner, "Geometric Numerical Integration", 2006, section I.1.4), with the
/// oscillator's energy bounded up to two radians a step. Rotors count with their means over the
/// step.
inline constexpr StepRule kMidpointRule{
    IntegratorChoice::kMidpoint, 2, {kStepMiddle, kStepMiddle}, {0.0, 0.5}};
/// Most evaluations of a step by kMidpointRule, of which two are the usual case.
inline constexpr int kMostEvaluations = 14;
/// Semi-implicit (symplectic) Euler, order 1: u += dt udot, then q += dt N(q) u. Rotors count with
/// their speed in mid-step.
inline constexpr StepRule kSemiImplicitEulerRule{
    IntegratorChoice::kSemiImplicitEuler, 1, {kStepMiddle}, {0.0}};
/// The classical Runge-Kutta method, order 4; rotors follow their closed form at the stages' times.
inline constexpr StepRule kRungeKutta4Rule{IntegratorChoice::kRk4,
                                           4,
                                           {kStepStart, kStepMiddle, kStepMiddle, kStepEnd},
                                           {0.0, 0.5, 0.5, 1.0}};

/// Of an integrator with fixed steps.
SKYBODY_INLINE const StepRule& step_rule(IntegratorChoice integrator) {
  if (integrator == IntegratorChoice::kRk4) return kRungeKutta4Rule;
  return integrator == IntegratorChoice::kMidpoint ? kMidpointRule : kSemiImplicitEulerRule;
}

/// Where a rule keeps its rates.
template <class State>
struct StageRates {
  State point;               ///< a stage's
  State outer, inner, rate;  ///< of the first stage, the second, and those behind
};

/// One step by a rule whose first stage is the step's start: not kMidpointRule. A split rule's
/// rates are left in `work.outer`, with the state as it was.
/// @tparam State  has set(start, rate, time): start + time rate, element by element, where start
///                may be the state itself; and add(rate)
/// @param rates   rates(state, time, rate) writes what the state changes by in a second. It is
///                evaluated at one place in the loop, since its code is large
/// @param state   at the step's start; written: at its end
template <class State, class Rates>
SKYBODY_INLINE void step_by_stages(const StepRule& rule, double dt, const Rates& rates,
                                   State& state, StageRates<State>& work) {
  State* const rate[4] = {&work.outer, &work.inner, &work.rate, &work.rate};
#pragma GCC unroll 1
  for (int k = 0; k < rule.stages; ++k) {
    if (k > 0) work.point.set(state, *rate[k - 1], dt * rule.reach[k]);
    rates(k == 0 ? state : work.point, rule.time[k], *rate[k]);
    if (k == 2) work.inner.add(work.rate);
  }
  if (rule.is_split()) return;
  work.outer.add(work.rate);
  work.outer.set(work.outer, work.inner, 2.0);
  state.set(state, work.outer, dt / 6.0);
}

/// One step by kMidpointRule.
/// @tparam State  has change_velocity(rate, time), and kick(start, rate, time): start, its velocity
///                changed
/// @param rates   as for step_by_stages, evaluated at one place; only the velocity's are asked for
/// @param drift   drift(is_first) moves the state for half a step at its velocities
/// @param goes_on  goes_on() says after the second evaluation, and those behind it, whether there
///                is to be one more, at a point that it has brought nearer to the mean velocity
template <class Time, class State, class Rates, class Drift, class GoesOn>
SKYBODY_INLINE void step_by_midpoint(const Time& dt, const Rates& rates, const Drift& drift,
                                     const GoesOn& goes_on, State& state, StageRates<State>& work) {
  drift(true);
  State* at = &state;
#pragma GCC unroll 1
  for (int k = 0; k < kMostEvaluations; ++k) {
    rates(*at, kStepMiddle, work.rate);
    if (k == 0) {
      work.point.kick(state, work.rate, dt * kMidpointRule.reach[1]);
      at = &work.point;
    } else if (!goes_on()) {
      break;
    }
  }
  state.change_velocity(work.rate, dt);
  drift(false);
}

}  // namespace skybody
