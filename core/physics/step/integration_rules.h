// Rules common to all kernels of a physics step: rotor motion, coordinates of driven bases, and the
// explicit integration rules. On double and packs.
#pragma once

#include "core/physics/forces/base_drive.h"
#include "core/physics/forces/rotor_lag.h"

namespace skybody {

/// A state beyond this [m, rad, m/s, rad/s] has diverged: it is a thousand kilometres away, or
/// faster than any rotor.
inline constexpr double kLargestState = 1e6;

/// Threshold of the square of a body's spin [rad^2/s^2]. Above it, rules with one evaluation in
/// mid-step move the body by its torque-free motion (bodies/torque_free.h), and only forces change
/// its velocities.
///
/// Below it, the midpoint rule integrates the body's gyroscopic torque explicitly. The energy of a
/// wobble, whose frequency is at most the spin w, grows by (w dt)^4 / 4 per step. At the threshold
/// this is at most 1 % per minute (29 rad/s at 1 ms, 10 rad/s at 4 ms).
SKYBODY_INLINE double fast_spin_square(double dt) {
  constexpr double kGrowth = 0.01 / 60.0;  // of energy [1/s]
  return sqrt(4.0 * kGrowth / (dt * dt * dt));
}

/// A rotor's command during one step; computes the rotor's motion.
template <class Real>
struct RotorStep {
  RotorLag<Real> lag;
  Real speed;    ///< at the start of the step [rad/s]
  Real command;  ///< constant, within the rotor's limits [rad/s]

  /// @param held  the command; @param max_speed, min_speed  the rotor's limits
  SKYBODY_INLINE RotorStep(const RotorLag<Real>& l, const Real& start, const Real& held,
                           const Real& max_speed, const Real& min_speed = Real(0.0))
      : lag(l), speed(start), command(limit_command(held, max_speed, min_speed)) {}

  SKYBODY_INLINE RotorMotion<Real> at(StageTime time) const {
    return rotor_at(lag, speed, command, time);
  }
  /// Speed in mid-step, with the change of speed over the step instead of an acceleration.
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

/// A rotor that may spin backwards: its squares have a sign.
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

/// Sets the rates of a driven base for the coming step.
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

/// An explicit one-step rule as its stages: the points at which it evaluates the rates.
struct StepRule {
  IntegratorChoice integrator;
  int stages;
  StageTime time[4];  ///< of the rotors
  double reach[4];    ///< from the step's start with the rates of the previous stage [dt]

  /// Whether rates change only velocities, and velocities change coordinates.
  constexpr bool is_split() const { return integrator != IntegratorChoice::kRk4; }
};
/// The midpoint rule, order 2:
/// 1. half a step of the coordinates at the initial velocities,
/// 2. a step of the velocities by the explicit midpoint rule at these coordinates,
/// 3. half a step of the coordinates at the final velocities.
/// If forces depend only on coordinates, this is the leapfrog (E. Hairer, C. Lubich, G. Wanner,
/// "Geometric Numerical Integration", 2006, section I.1.4); the oscillator's energy is bounded up
/// to two radians per step. Rotors enter with their means over the step.
inline constexpr StepRule kMidpointRule{
    IntegratorChoice::kMidpoint, 2, {kStepMiddle, kStepMiddle}, {0.0, 0.5}};
/// Maximum number of evaluations of a step by kMidpointRule; two are the usual case.
inline constexpr int kMostEvaluations = 14;
/// Semi-implicit (symplectic) Euler, order 1: u += dt udot, then q += dt N(q) u. Rotors enter with
/// their speed in mid-step.
inline constexpr StepRule kSemiImplicitEulerRule{
    IntegratorChoice::kSemiImplicitEuler, 1, {kStepMiddle}, {0.0}};
/// The classical Runge-Kutta method, order 4; rotors follow their closed form at the stages' times.
inline constexpr StepRule kRungeKutta4Rule{IntegratorChoice::kRk4,
                                           4,
                                           {kStepStart, kStepMiddle, kStepMiddle, kStepEnd},
                                           {0.0, 0.5, 0.5, 1.0}};

/// The rule of an integrator with fixed steps.
SKYBODY_INLINE const StepRule& step_rule(IntegratorChoice integrator) {
  if (integrator == IntegratorChoice::kRk4) return kRungeKutta4Rule;
  return integrator == IntegratorChoice::kMidpoint ? kMidpointRule : kSemiImplicitEulerRule;
}

/// Work memory for a rule's rates.
template <class State>
struct StageRates {
  State point;               ///< state of a stage
  State outer, inner, rate;  ///< of the first stage, the second, and the later ones
};

/// One step by a rule whose first stage is the step's start, that is, not kMidpointRule. The rates
/// of a split rule are left in `work.outer`, and the state stays unchanged.
/// @tparam State  has set(start, rate, time): start + time rate, element by element, where start
///                may be the state itself; and add(rate)
/// @param rates   rates(state, time, rate) writes the state's rate of change. Called at one place
///                in the loop, since its code is large
/// @param state   in: at the step's start; out: at its end
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
/// @tparam State  has change_velocity(rate, time), and kick(start, rate, time): copies start and
///                changes its velocity
/// @param rates   as for step_by_stages, called at one place; only rates of velocity are used
/// @param drift   drift(is_first) moves the state for half a step at its velocities
/// @param goes_on  goes_on() is called after the second and each later evaluation: whether another
///                evaluation follows, at a point that it has moved closer to the mean velocity
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
