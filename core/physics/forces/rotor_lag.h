// First-order rotor lag in closed form, paper eq. 2:
//   w(t) = w_ref + (w(0) - w_ref) exp(-t / tau), tau = tau_up while speeding up, otherwise
//   tau_down.
// A time constant of 0 is an immediate jump. The exponentials depend only on parameters and dt, so
// they are computed once per change of the parameters.
#pragma once

#include <type_traits>

#include "core/base/math/math.h"
#include "core/model/state_layout.h"

namespace skybody {

/// Instants of a physics step at which integrators evaluate forces.
enum StageTime : int { kStepStart = 0, kStepMiddle = 1, kStepEnd = 2, kStageTimeCount = 3 };

/// Motion of a rotor at one instant, or its means over a step. Only reversible rotors have negative
/// speeds.
template <class Real>
struct RotorMotion {
  Real speed;         ///< w [rad/s]
  Real acceleration;  ///< [rad/s^2]
  Real squared;       ///< w |w| [rad^2/s^2]: a mean of squares is not the mean's square
};

/// Motion at an instant.
template <class Real>
SKYBODY_INLINE RotorMotion<Real> rotor_motion(const Real& speed, const Real& acceleration) {
  return {speed, acceleration, speed * speed};
}

/// Lag of one time constant over one physics step.
template <class Real>
struct LagFactors {
  Real decay[kStageTimeCount];  ///< exp(-t/tau); all 0 for tau = 0
  Real slope[kStageTimeCount];  ///< acceleration per (w_ref - w(0)) [1/s]
  Real half_mean;               ///< half the mean of exp(-t/tau) over the step
};

/// Lag factors of one rotor, for speeding up and for slowing down.
template <class Real>
struct RotorLag {
  LagFactors<Real> up, down;
};

/// The slopes are those of the exponential, scaled so that Simpson's rule over start, middle and
/// end gives exactly the change of speed. The reaction to spin-up then transfers exactly the
/// rotor's change of angular momentum, even for time constants far below dt. For tau >> dt the
/// scale is 1 + O((dt/tau)^4), so fourth-order integrators keep their order.
/// @param tau [s] >= 0
/// @param dt  physics step [s]
template <class Real>
SKYBODY_INLINE LagFactors<Real> make_lag_factors(const Real& tau, double dt) {
  const auto immediate = tau <= 0.0;
  const Real safe_tau = select(immediate, Real(1.0), tau);
  const Real zero(0.0), one(1.0);
  LagFactors<Real> f;
  f.decay[kStepStart] = select(immediate, zero, one);
  f.decay[kStepMiddle] = select(immediate, zero, exp(-(0.5 * dt) / safe_tau));
  f.decay[kStepEnd] = select(immediate, zero, exp(-dt / safe_tau));
  // 1 - exp(-x) without cancellation.
  const Real mean_slope = select(immediate, one, -expm1(-dt / safe_tau)) / dt;
  const Real simpson = (f.decay[kStepStart] + 4.0 * f.decay[kStepMiddle] + f.decay[kStepEnd]) / 6.0;
  const Real safe_simpson = select(immediate, one, simpson);
  for (int i = 0; i < kStageTimeCount; ++i) {
    const Real share = select(immediate, one, f.decay[i] / safe_simpson);
    f.slope[i] = mean_slope * share;
  }
  f.half_mean = (0.5 * tau) * mean_slope;  // 0 if immediate
  return f;
}

/// @param constants the rotor's kRotorParamCount values: a pointer, or a view
template <class Values>
SKYBODY_INLINE auto make_rotor_lag(const Values& constants, double dt) {
  using Real = std::decay_t<decltype(constants[kTauUp])>;
  return RotorLag<Real>{make_lag_factors<Real>(constants[kTauUp], dt),
                        make_lag_factors<Real>(constants[kTauDown], dt)};
}

/// Number of values in a RotorLag<double>, which has the memory layout of an array.
inline constexpr int kLagSize = 2 * (2 * kStageTimeCount + 1);
static_assert(sizeof(RotorLag<double>) == kLagSize * sizeof(double));

/// Loads a lag from `values`, in the order of the members.
template <class Real, class Values>
SKYBODY_INLINE RotorLag<Real> load_lag(const Values& values) {
  const auto factors = [](const Values& v) {
    return LagFactors<Real>{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6]};
  };
  return {factors(values), factors(values + kLagSize / 2)};
}

/// Clamps a rotor's command to [min_speed, max_speed]; NaN stays NaN.
template <class Real>
SKYBODY_INLINE Real limit_command(const Real& command, const Real& max_speed,
                                  const Real& min_speed = Real(0.0)) {
  return clamp(command, min_speed, max_speed);
}

/// The lag of a rotor that may spin backwards, with one time constant in both directions: tau_up if
/// |speed| is to grow, otherwise tau_down.
template <class Real>
SKYBODY_INLINE RotorLag<Real> lag_by_size(const RotorLag<Real>& lag, const Real& speed,
                                          const Real& command) {
  const auto grows = abs(command) > abs(speed);
  LagFactors<Real> f;
  for (int i = 0; i < kStageTimeCount; ++i) {
    f.decay[i] = select(grows, lag.up.decay[i], lag.down.decay[i]);
    f.slope[i] = select(grows, lag.up.slope[i], lag.down.slope[i]);
  }
  f.half_mean = select(grows, lag.up.half_mean, lag.down.half_mean);
  return {f, f};
}

/// The rotor at an instant of the step.
/// @param speed   at the start of the step [rad/s]
/// @param command limited command, held during the step [rad/s]
template <class Real>
SKYBODY_INLINE RotorMotion<Real> rotor_at(const RotorLag<Real>& lag, const Real& speed,
                                          const Real& command, StageTime t) {
  const auto rising = command > speed;
  const Real decay = select(rising, lag.up.decay[t], lag.down.decay[t]);
  const Real slope = select(rising, lag.up.slope[t], lag.down.slope[t]);
  const Real gap = command - speed;
  // Exactly the command for a decay of 0, and exactly the speed at the start for a decay of 1.
  if (t == kStepStart) return rotor_motion<Real>(select(decay == 0.0, command, speed), gap * slope);
  return rotor_motion<Real>(command - gap * decay, gap * slope);
}

/// Means over the step of the speed and of its square, in closed form. `acceleration` is the change
/// of speed over the step instead.
/// @param end  speed at the end of the step [rad/s]
template <class Real>
SKYBODY_INLINE RotorMotion<Real> rotor_over_step(const RotorLag<Real>& lag, const Real& speed,
                                                 const Real& command, const Real& end) {
  const auto rising = command > speed;
  // With w = command - gap d, d = exp(-t/tau): w^2 = command^2 - 2 command gap d + gap^2 d^2. The
  // mean of d^2 is the mean of d times the mean of d at the two ends.
  const Real lacking = (command - speed) * select(rising, lag.up.half_mean, lag.down.half_mean);
  return {command - (lacking + lacking), end - speed,
          command * command - lacking * ((command + command) + (speed + end))};
}

/// Mean over the step of w |w|, where w may change its sign.
///
/// With w = c - g d, d = exp(-t / tau), the sign changes where d = z = c / g. Up to there
///   (1/dt) integral of w^2 = g^2 (tau / dt) ((1 - z^2) / 2 - 2 z (1 - z) - z^2 log z),
/// which gets the sign of the start; the rest gets the sign of the end.
/// @param lag     lag_by_size()
/// @param square  mean of w^2
template <class Real>
SKYBODY_INLINE Real mean_signed_square(const RotorLag<Real>& lag, const Real& speed,
                                       const Real& command, const Real& end, const Real& square) {
  const Real signed_square = copysign(square, speed + end);
  const auto turns = speed * end < 0.0;
  if (none(turns)) return signed_square;
  const Real zero(0.0), one(1.0);
  const Real gap = select(turns, command - speed, one);
  const Real z = select(turns, command / gap, one);
  const Real decay = lag.up.decay[kStepEnd];
  const Real share = (lag.up.half_mean + lag.up.half_mean) / select(turns, one - decay, one);
  const Real before =
      (gap * gap) * share * (0.5 * (one - z * z) - 2.0 * z * (one - z) - z * z * log(z));
  const Real rest = square - 2.0 * max(before, zero);
  return select(turns, select(end < 0.0, -rest, rest), signed_square);
}

/// The rotor at any time of the step, by the closed form: for integrators that choose their own
/// instants.
/// @param constants the rotor's kRotorParamCount values: a pointer, or a view
/// @param speed     at the start of the step [rad/s]
/// @param command   limited command, held during the step [rad/s]
/// @param time      since the start of the step [s]
/// @param dt        the step [s]; the reaction to a jump (time constant 0) is spread over it
template <class Values>
RotorMotion<double> rotor_at_time(const Values& constants, double speed, double command,
                                  double time, double dt) {
  const double gap = command - speed;
  const double tau = abs(command) > abs(speed) ? constants[kTauUp] : constants[kTauDown];
  if (tau <= 0.0) return rotor_motion(command, gap / dt);
  const double rest = gap * exp(-time / tau);
  return rotor_motion(command - rest, rest / tau);
}

}  // namespace skybody
