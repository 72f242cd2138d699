// Motors in joints: a generalised force on one coordinate, from a command with a first-order lag.
#pragma once

#include "core/base/math/math.h"
#include "core/physics/forces/rotor_lag.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A joint drive of a world with its lag over one physics step.
struct JointDriveStep {
  JointDrive drive;
  LagFactors<double> lag;
  int q = 0, u = 0;  ///< the coordinate and its rate, within the blocks
};

/// Target of a drive at an instant of the step: r(t) = c + (r(0) - c) exp(-t / tau).
/// @param state    r(0), at the start of the step
/// @param command  c, held during the step
template <class Real>
SKYBODY_INLINE Real target_at(const LagFactors<double>& lag, const Real& state, const Real& command,
                              StageTime t) {
  if (lag.decay[t] == 0.0) return command;
  if (t == kStepStart) return state;
  return command - (command - state) * lag.decay[t];
}

/// The same at any time since the start of the step [s].
SKYBODY_INLINE double target_at_time(double tau, double state, double command, double time) {
  return tau > 0.0 ? command - (command - state) * exp(-time / tau) : command;
}

/// Generalised force along the coordinate [N m] or [N].
/// @param target  [rad], [rad/s] or [N m]; of a slider [m], [m/s] or [N]
/// @param q, u    the coordinate and its rate
template <class Real>
SKYBODY_INLINE Real drive_force(const JointDrive& drive, const Real& target, const Real& q,
                                const Real& u) {
  Real effort = target;
  if (drive.mode == JointMode::kPosition) {
    effort = drive.stiffness * (target - q) - drive.damping * u;
  } else if (drive.mode == JointMode::kVelocity) {
    effort = drive.damping * (target - u);
  }
  return clamp(effort, Real(-drive.effort_limit), Real(drive.effort_limit));
}

}  // namespace skybody
