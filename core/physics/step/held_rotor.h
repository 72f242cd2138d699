// A rotor with held inputs during a physics step.
#pragma once

#include "core/physics/step/integration_rules.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// Limits of a rotor's speed [rad/s].
template <class Real>
struct HeldLimits {
  Real lower, upper;
};

/// Limits of rotor i of the world; the limits must be held.
template <class Real>
SKYBODY_INLINE HeldLimits<Real> held_limits(const HeldLanes<Real>& held, int i) {
  const LaneValues<Real> limits = held[SKYBODY_HELD_ROTOR_LIMIT] + 2 * i;
  return {limits[0], limits[1]};
}

/// Held inputs of a rotor.
template <class Real>
struct HeldRotor : HeldLimits<Real> {
  Real rate;  ///< its acceleration [rad/s^2]; NaN: use the lag
};

/// A rotor with held inputs. Its command is clamped to the held limits, or its speed changes at the
/// held rate: linearly, up to the same limits at the end of the step. A speed beyond the limits at
/// the start returns to them at most as fast as by the lag.
template <class Real>
struct HeldRotorStep {
  RotorStep<Real> lagged;
  MaskOf<Real> is_linear;
  Real change;  ///< of the speed, if it changes linearly [rad/s]
  double dt;

  SKYBODY_INLINE HeldRotorStep(const RotorLag<Real>& lag, const Real& start, const Real& command,
                               const Real& max_speed, const HeldRotor<Real>& held, double step,
                               const Real& min_speed = Real(0.0))
      : lagged(lag, start, clamp(command, held.lower, held.upper), max_speed, min_speed),
        is_linear(held.rate == held.rate),
        change(limit_command(limited(start + held.rate * step, held), max_speed, min_speed) -
               start),
        dt(step) {}

  SKYBODY_INLINE RotorMotion<Real> at(StageTime time) const {
    return choose(lagged.at(time), time == kStepStart ? 0.0 : time == kStepMiddle ? 0.5 : 1.0);
  }
  SKYBODY_INLINE RotorMotion<Real> in_middle(const Real& end) const {
    return rotor_motion<Real>(at(kStepMiddle).speed, end - lagged.speed);
  }
  SKYBODY_INLINE RotorMotion<Real> mean(const Real& end) const {
    const RotorMotion<Real> lag = lagged.mean(end);
    const Real& start = lagged.speed;
    const Real squared = start * (start + change) + change * change / 3.0;
    return {select(is_linear, start + change * 0.5, lag.speed), lag.acceleration,
            select(is_linear, squared, lag.squared)};
  }
  /// Mean of w |w|; for a linear change from a to b: (|b|^3 - |a|^3) / (3 (b - a)).
  /// @param square  mean of w^2
  SKYBODY_INLINE Real mean_signed_square(const Real& end, const Real& square) const {
    const Real& start = lagged.speed;
    const auto moves = logical_and(is_linear, change != 0.0);
    const Real linear = (abs(end) * (end * end) - abs(start) * (start * start)) /
                        (3.0 * select(moves, change, Real(1.0)));
    return select(is_linear, select(moves, linear, start * abs(start)),
                  lagged.mean_signed_square(end, square));
  }
  template <class Constants>
  RotorMotion<double> at_time(const Constants& constants, double time, double step) const {
    return choose(lagged.at_time(constants, time, step), time / step);
  }

 private:
  SKYBODY_INLINE Real limited(const Real& speed, const HeldRotor<Real>& held) const {
    const Real by_lag = lagged.at(kStepEnd).speed;
    return clamp(speed, min(held.lower, by_lag), max(held.upper, by_lag));
  }
  /// @param share  elapsed fraction of the step
  SKYBODY_INLINE RotorMotion<Real> choose(const RotorMotion<Real>& lag, double share) const {
    return rotor_motion<Real>(select(is_linear, lagged.speed + change * share, lag.speed),
                              select(is_linear, change / dt, lag.acceleration));
  }
};

/// Limits of a rotor that may spin backwards: if the lower limit is 0, the neutral value, the upper
/// limit holds in both directions.
template <class Real>
SKYBODY_INLINE void limit_both_senses(HeldLimits<Real>& limits) {
  limits.lower = select(limits.lower == 0.0, -limits.upper, limits.lower);
}

/// Held inputs of rotor i of the world; inputs that are not held have neutral values.
template <class Real>
SKYBODY_INLINE HeldRotor<Real> held_rotor(const HeldLanes<Real>& held, int i) {
  HeldRotor<Real> rotor{{Real(0.0), Real(kInfinity)}, Real(kNan)};
  if (held.has(SKYBODY_HELD_ROTOR_LIMIT)) {
    static_cast<HeldLimits<Real>&>(rotor) = held_limits(held, i);
  }
  if (held.has(SKYBODY_HELD_ROTOR_RATE)) rotor.rate = held[SKYBODY_HELD_ROTOR_RATE][i];
  return rotor;
}

}  // namespace skybody
