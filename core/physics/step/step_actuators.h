// Rotors and joint drives during a physics step of the environments of one Real: their speeds and
// targets follow from the commands in closed form.
#pragma once

#include "core/physics/step/held_rotor.h"
#include "core/physics/step/tree_accelerations.h"

namespace skybody {

/// @tparam Values  access to parameters and values derived from them: LaneValues, SharedValues
template <class Real, class Values, TreeKind kKind>
class StepActuators {
 public:
  /// @param first   of the lanes of Real
  /// @param arrays  `rotors` and `joint_targets` are written
  SKYBODY_INLINE StepActuators(const StepCall& call, int first, const Values& params,
                               const Values& derived, StepArrays<Real>& arrays)
      : plan_(*call.plan),
        group_(*call.group),
        lanes_(first),
        held_(group_.held, first),
        params_(params),
        derived_(derived),
        a_(arrays) {}

  /// Held inputs of the lanes.
  SKYBODY_INLINE const HeldLanes<Real>& held() const { return held_; }

  /// Constants of rotor i of the world.
  SKYBODY_INLINE Values rotor_constants(int i) const {
    return params_ + plan_.world.layout.rotor_params[static_cast<std::size_t>(i)];
  }

  /// Calls f(i, step of the rotor) for every rotor of the world.
  template <class F>
  SKYBODY_INLINE void each_rotor(const F& f) const {
    for (int i = 0; i < static_cast<int>(plan_.world.rotors.size()); ++i) {
      const auto lag = load_lag<Real>(derived_ + (plan_.derived.lags + kLagSize * i));
      const Real speed = lanes_.load(group_.rotor_speed, i);
      const Real command = lanes_.load(group_.rotor_command, i);
      const Real max_speed = rotor_constants(i)[kMaxSpeed];
      if constexpr (kIsAny) {
        const Rotor& model = *plan_.world.rotors[static_cast<std::size_t>(i)].model;
        if (model.is_reversible()) {
          run_reversible(i, lag, speed, command, max_speed, Real(model.min_speed), f);
        } else {
          f(i, HeldRotorStep<Real>(lag, speed, command, max_speed, held_rotor(held_, i), dt()));
        }
      } else {
        f(i, RotorStep<Real>(lag, speed, command, max_speed));
      }
    }
  }

  /// Calls f(i, drive, state, command) for every joint drive of the world.
  template <class F>
  SKYBODY_INLINE void each_drive(const F& f) const {
    int i = 0;
    for (const JointDriveStep& drive : plan_.forces.joint_drives()) {
      f(i, drive, lanes_.load(group_.joint_state, i),
        clamp(lanes_.load(group_.joint_command, i), Real(drive.drive.low), Real(drive.drive.high)));
      ++i;
    }
  }

  /// Computes rotor motions. Rules with evaluations in mid-step only use the change of speed over
  /// the step.
  SKYBODY_INLINE void run_rotors(const StepRule& rule) const {
    const double rate = 1.0 / dt();
    each_rotor([&](int i, const auto& rotor) SKYBODY_INLINE_LAMBDA {
      a_.rotors[kStepEnd][i] = rotor.at(kStepEnd);
      if (rule.is_split()) {
        const Real& end = a_.rotors[kStepEnd][i].speed;
        RotorMotion<Real>& middle = a_.rotors[kStepMiddle][i];
        middle =
            rule.integrator == IntegratorChoice::kMidpoint ? rotor.mean(end) : rotor.in_middle(end);
        middle.acceleration *= rate;
        return;
      }
      a_.rotors[kStepStart][i] = rotor.at(kStepStart);
      a_.rotors[kStepMiddle][i] = rotor.at(kStepMiddle);
    });
  }

 private:
  static constexpr bool kIsAny = kKind == TreeKind::kAny;

  double dt() const { return plan_.world.scenario.stepping.dt; }

  /// Calls f(i, step of the rotor) for a rotor that may spin backwards.
  template <class F>
  SKYBODY_INLINE void run_reversible(int i, const RotorLag<Real>& lag, const Real& speed,
                                     const Real& command, const Real& max_speed,
                                     const Real& min_speed, const F& f) const {
    HeldRotor<Real> held = held_rotor(held_, i);
    limit_both_senses(held);
    const Real goal = limit_command(clamp(command, held.lower, held.upper), max_speed, min_speed);
    using Step = HeldRotorStep<Real>;
    f(i, ReversibleRotorStep<Real, Step>{Step(lag_by_size(lag, speed, goal), speed, command,
                                              max_speed, held, dt(), min_speed)});
  }

  const StepPlan& plan_;
  const GroupBlocks& group_;
  LaneSlice<Real> lanes_;
  HeldLanes<Real> held_;
  Values params_, derived_;
  StepArrays<Real>& a_;
};

}  // namespace skybody
