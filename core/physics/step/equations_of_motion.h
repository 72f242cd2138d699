// The equations of motion, and a physics step, of the environments of one Real: one environment
// (double) or several of a group side by side (a pack), with the same operations in the same order.
#pragma once

#include <type_traits>

#include "core/physics/step/step_actuators.h"
#include "core/physics/step/step_arrays.h"
#include "core/physics/step/stop_correction.h"
#include "core/physics/step/tree_accelerations.h"

namespace skybody {

/// @tparam Values         access to parameters and values derived from them: LaneValues,
///                        SharedValues
/// @tparam Accelerations  computes accelerations from forces
template <class Real, class Values, TreeKind kKind, class Accelerations = TreeAccelerations>
class EquationsOfMotion {
 public:
  /// @param first   of the lanes of Real
  /// @param arrays  of the call's scratch memory
  SKYBODY_INLINE EquationsOfMotion(const StepCall& call, int first, const Values& params,
                                   const Values& derived, StepArrays<Real>& arrays,
                                   const Accelerations& accelerations = {})
      : plan_(*call.plan),
        group_(*call.group),
        spins_(call.spins),
        lanes_(first),
        params_(params),
        derived_(derived),
        accelerations_(accelerations),
        a_(arrays),
        actuators_(call, first, params, derived, arrays),
        couplings_(plan_.couplings, plan_.multibody, a_.couplings),
        fast_(plan_, a_.fast, a_.fast_bodies, a_.motion) {}

  /// Normalises quaternions; computes bodies and spins from q and u.
  SKYBODY_INLINE void refresh(const MaskOf<Real>& mask) {
    load_coordinates();
    for (const TreeBody& body : tree()) make_unit(body.type, a_.now.q + body.q);
    update_motion(a_.now.q, a_.now.u);
    lanes_.store(a_.now.q, layout().q.size, mask, group_.q);
    put_motion(mask);
  }

  /// The same for coordinates that are already normalised.
  SKYBODY_INLINE void find_motion(const MaskOf<Real>& mask) {
    load_coordinates();
    update_motion(a_.now.q, a_.now.u);
    put_motion(mask);
  }

  /// Projects coordinates onto the couplings. @returns the lanes of `mask` in which this succeeded
  SKYBODY_INLINE MaskOf<Real> project_constraints(const MaskOf<Real>& mask) {
    load_coordinates();
    couplings_.load(params_, derived_ + plan_.derived.bodies);
    const MaskOf<Real> is_closed = couplings_.project(mask, Real(dt()), a_.now.q, a_.now.u);
    update_motion(a_.now.q, a_.now.u);
    lanes_.store(a_.now.q, layout().q.size, is_closed, group_.q);
    lanes_.store(a_.now.u, layout().u.size, is_closed, group_.u);
    put_motion(is_closed);
    return is_closed;
  }

  /// One physics step of the lanes in `mask` by a fixed rule; returns the lanes that succeeded.
  SKYBODY_INLINE MaskOf<Real> advance(const MaskOf<Real>& mask) {
    const StepRule& rule = step_rule(plan_.world.scenario.stepping.integrator);
    begin_step();
    MaskOf<Real> taken = mask;
    if (rule.is_split()) taken = logical_and(taken, find_fast(mask));
    if (none(taken)) return taken;
    actuators_.run_rotors(rule);
    const auto rates = [&](const Coordinates<Real>& at, StageTime time, Coordinates<Real>& rate)
                           SKYBODY_INLINE_LAMBDA {
                             accelerate(at.q, at.u, time, rate.u);
                             if constexpr (kIsAny)
                               fast_.subtract_torque_free_rates(a_.motion, at.u, rate.u);
                             if (!rule.is_split()) position_rates_of(at.q, at.u, rate.q);
                           };
    if (rule.integrator == IntegratorChoice::kMidpoint) {
      advance_by_midpoint(taken, rates);
      return end_step(taken);
    }
    step_by_stages(rule, dt(), rates, a_.now, a_.stages);
    if (rule.is_split()) {
      a_.now.change_velocity(a_.stages.outer, dt());
      drift(Real(dt()), false, [&]() SKYBODY_INLINE_LAMBDA { a_.now.change_position(dt()); });
    }
    return end_step(taken);
  }

  /// The same with an integrator that chooses its own times.
  /// @param advance  advance(rates, q, u), with rates as in integrator.h
  template <class Advance>
  SKYBODY_INLINE MaskOf<Real> advance_by(const Advance& advance, const MaskOf<Real>& mask) {
    begin_step();
    actuators_.each_rotor(
        [&](int i, const auto& rotor) { a_.rotors[kStepEnd][i] = rotor.at(kStepEnd); });
    const auto rates = [&](const Real* q, const Real* u, double time, Real* qdot, Real* udot) {
      actuators_.each_rotor([&](int i, const auto& rotor) {
        a_.rotors[kStepMiddle][i] = rotor.at_time(actuators_.rotor_constants(i), time, dt());
      });
      actuators_.each_drive(
          [&](int i, const JointDriveStep& d, const Real& state, const Real& command) {
            a_.joint_targets[kStepMiddle][i] = target_at_time(d.drive.tau, state, command, time);
          });
      has_motion_ = false;  // it evaluates at other points
      accelerate(q, u, kStepMiddle, udot);
      position_rates_of(q, u, qdot);
    };
    advance(rates, a_.now.q, a_.now.u);
    return end_step(mask);
  }

  /// Accelerations at the step's start; those by stops are means over a step.
  /// @param contact  contact forces, one per body; null: none
  SKYBODY_INLINE void accelerations(const SpatialForce<Real>* contact, Real* udot) {
    contact_ = contact;
    begin_step();
    actuators_.each_rotor(
        [&](int i, const auto& rotor) { a_.rotors[kStepStart][i] = rotor.at(kStepStart); });
    accelerate(a_.now.q, a_.now.u, kStepStart, udot);
    if (plan_.stops.any()) stops().add_accelerations(udot);
    if (couplings_.any()) couplings_.add_coupling_forces(a_.motion, a_.forces);
  }
  /// Values of the last evaluation: motion of the bodies, and all forces on them except those of
  /// joints.
  const BodyKinematics<Real>* motion() const { return a_.motion; }
  SpatialForce<Real>* forces() const { return a_.forces; }

 private:
  static constexpr bool kIsAny = kKind == TreeKind::kAny;

  double dt() const { return plan_.world.scenario.stepping.dt; }
  const StateLayout& layout() const { return plan_.world.layout; }
  const std::vector<TreeBody>& tree() const { return plan_.multibody.bodies(); }
  SKYBODY_INLINE StopCorrection<Real, Values> stops() const {
    return {plan_, params_, derived_, a_};
  }
  int body_count() const { return static_cast<int>(plan_.world.bodies.size()); }

  template <class Rates>
  SKYBODY_INLINE void advance_by_midpoint(const MaskOf<Real>& mask, const Rates& rates) {
    stays_ = true;
    if constexpr (kIsAny) {
      advance_in_parts(mask, rates);
    } else {
      has_motion_ = false;
      const auto drift = [&](bool) SKYBODY_INLINE_LAMBDA { a_.now.drift(0.5 * dt()); };
      const auto goes_on = []() SKYBODY_INLINE_LAMBDA { return false; };
      step_by_midpoint(dt(), rates, drift, goes_on, a_.now, a_.stages);
    }
  }

  /// Takes substeps if robots with joints spin fast; a lane keeps its state after its last substep.
  template <class Rates>
  SKYBODY_INLINE void advance_in_parts(const MaskOf<Real>& mask, const Rates& rates) {
    const Real parts = fast_.parts(dt());
    const Coordinates<Real>& before = a_.stages.outer;
#pragma GCC unroll 1
    for (int p = 0; p < kMostFastParts; ++p) {
      const auto is_active = logical_and(mask, parts > static_cast<double>(p));
      if (none(is_active)) break;
      const Real step = fast_.part_time(dt(), parts, p), half = 0.5 * step;
      const auto move = [&](bool is_first) SKYBODY_INLINE_LAMBDA {
        drift(half, is_first, [&]() SKYBODY_INLINE_LAMBDA { a_.now.drift(half); });
      };
      const auto goes_on = [&]() SKYBODY_INLINE_LAMBDA { return approach_mean(half); };
      if (p > 0) {
        before.copy(a_.now);
        couplings_.remember();
      }
      has_motion_ = has_response_ = false;
      is_open_ = logical_and(is_active, fast_.iterates());
      step_by_midpoint(step, rates, move, goes_on, a_.now, a_.stages);
      if (p == 0 || all(is_active)) continue;
      a_.now.keep(is_active, before);
      couplings_.take_back(is_active);
    }
  }

  /// Moves the robots for a time without forces: see HighSpinRobots::drift.
  template <class Slowly>
  SKYBODY_INLINE void drift(const Real& time, bool locks, const Slowly& slowly) const {
    if constexpr (kIsAny) {
      fast_.drift(time, locks, a_.now, slowly);
    } else {
      slowly();
    }
  }

  /// Finds robots that spin fast at the step's start.
  /// @returns the lanes whose step this kind takes. kUsual rejects the whole pack if a lane of
  ///          `mask` is fast: kAny computes all of its lanes anyway, with the same bits for slow
  ///          ones
  SKYBODY_INLINE MaskOf<Real> find_fast(const MaskOf<Real>& mask) {
    if constexpr (kIsAny) {
      fast_.find(a_.motion);
      fast_.each_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
        const int first = kBodyConstantCount * robot.first_body;
        for (int k = first; k < first + kBodyConstantCount * robot.body_count; ++k) {
          a_.fast_bodies[k] = derived_[plan_.derived.bodies + k];
        }
      });
      if (plan_.world.scenario.stepping.integrator != IntegratorChoice::kMidpoint) {
        fast_.lock_all(a_.now);
      }
      return MaskOf<Real>(true);
    } else {
      Real square(0.0);
      for (int i = 0; i < body_count(); ++i) square = max(square, squared_norm(a_.motion[i].spin));
      const bool has_fast = any(logical_and(mask, square > plan_.fast_square));
      return MaskOf<Real>(!has_fast);
    }
  }

  /// Moves the velocities of the second evaluation to the mean of the step, if robots with joints
  /// spin fast. The rule then becomes the implicit midpoint rule, whose energy does not grow.
  /// @param half  half the substep's time
  /// @returns whether they still change in any lane
  SKYBODY_INLINE bool approach_mean(const Real& half) {
    constexpr double kSmall = 1e-9;  // the remaining error is this times the substep's angle
    if (none(is_open_)) return false;
    Real* const point = a_.stages.point.u;
    MaskOf<Real> changes(false);
    for (int i = 0; i < layout().u.size; ++i) {
      const Real mean = a_.now.u[i] + half * a_.stages.rate.u[i];
      changes |= abs(mean - point[i]) > kSmall * (1.0 + abs(mean));
    }
    is_open_ &= changes;
    if (none(is_open_)) return false;
    for (int i = 0; i < layout().u.size; ++i) {
      const Real mean = a_.now.u[i] + half * a_.stages.rate.u[i];
      point[i] = select(is_open_, mean, point[i]);
    }
    return true;
  }

  /// Loads coordinates, commands and motion at the step's start.
  SKYBODY_INLINE void begin_step() {
    begin_motion();
    lanes_.load(group_.wrench, layout().wrench.size, a_.wrench);
    actuators_.each_drive([&](int i, const JointDriveStep& d, const Real& state,
                              const Real& command) SKYBODY_INLINE_LAMBDA {
      for (const StageTime time : {kStepStart, kStepMiddle, kStepEnd}) {
        a_.joint_targets[time][i] = target_at(d.lag, state, command, time);
      }
    });
    for (int i = 0; i < layout().u.size; ++i) a_.joint_forces[i] = Real(0.0);
    begin_drives();
    if (plan_.couplings.constraints.empty()) return;
    couplings_.load(params_, derived_ + plan_.derived.bodies);
    if (!couplings_.any()) return;
    if (!has_motion_) update_motion(a_.now.q, a_.now.u);
    has_motion_ = true;
    couplings_.begin(a_.motion);
  }

  SKYBODY_INLINE void begin_drives() {
    if (plan_.drives.empty()) return;
    lanes_.load(group_.drive, layout().drive.size, a_.drive);
    Real* target = a_.targets;
    for (const DrivenBase& drive : plan_.drives) {
      const TreeBody& base = tree()[static_cast<std::size_t>(drive.body)];
      begin_drive(drive.kind, a_.motion[drive.body], a_.drive + drive.value, dt(),
                  a_.now.q + base.q, a_.now.u + base.u, target);
      target += 7;
    }
    has_motion_ = false;
  }

  /// Loads coordinates and their motion.
  SKYBODY_INLINE void begin_motion() {
    load_coordinates();
    if (spins_ != nullptr) {
      load_motion(body_count(), lanes_, group_.bodies, spins_, a_.motion);
    } else {
      update_motion(a_.now.q, a_.now.u);
    }
    has_motion_ = true;
  }

  SKYBODY_INLINE void load_coordinates() {
    lanes_.load(group_.q, layout().q.size, a_.now.q);
    lanes_.load(group_.u, layout().u.size, a_.now.u);
  }

  /// @param time  of rotors and joint drives
  SKYBODY_INLINE void accelerate(const Real* q, const Real* u, StageTime time, Real* udot) {
    if (!has_motion_) update_motion(q, u);
    has_motion_ = false;
    const ForceInputs<Real, Values> in{q,
                                       u,
                                       a_.motion,
                                       a_.rotors[time],
                                       params_,
                                       a_.wrench,
                                       a_.joint_targets[time],
                                       kIsAny ? &actuators_.held() : nullptr};
    plan_.forces.evaluate(in, a_.forces, a_.joint_forces);
    for (int i = 0; contact_ != nullptr && i < body_count(); ++i) {
      a_.forces[i].moment += contact_[i].moment;
      a_.forces[i].force += contact_[i].force;
    }
    if (!plan_.couplings.constraints.empty()) couplings_.add_springs(params_, a_.motion, a_.forces);
    accelerations_(plan_, derived_, a_, q, u, udot);
    if (couplings_.any()) constrain(q, u, udot);
  }

  SKYBODY_INLINE void constrain(const Real* q, const Real* u, Real* udot) {
    couplings_.constrain(q, u, a_.motion, has_response_, udot);
    has_response_ = stays_;
    accelerations_.constrain(a_, q, u, couplings_.held(), udot);
  }

  SKYBODY_INLINE void position_rates_of(const Real* q, const Real* u, Real* qdot) const {
    for (const TreeBody& body : tree()) {
      position_rates(body.type, q + body.q, u + body.u, qdot + body.q);
    }
  }

  /// Ends the step: applies stops, normalises quaternions, and sets pose-driven bases exactly to
  /// their targets. Writes the lanes whose values are bounded.
  SKYBODY_INLINE MaskOf<Real> end_step(const MaskOf<Real>& mask) {
    if constexpr (kIsAny) {
      if (plan_.stops.any()) stops().correct_end(mask);
    }
    for (const TreeBody& body : tree()) normalize_position(body.type, a_.now.q + body.q);
    const Real* target = a_.targets;
    for (const DrivenBase& drive : plan_.drives) {
      Real* q = a_.now.q + tree()[static_cast<std::size_t>(drive.body)].q;
      for (int k = 0; drive.kind == DriveKind::kPose && k < 7; ++k) q[k] = target[k];
      target += 7;
    }
    MaskOf<Real> through = mask;
    if (couplings_.any()) {
      accelerations_.project(couplings_.held(), a_.now.q, a_.now.u);
      through &= couplings_.project(mask, Real(dt()), a_.now.q, a_.now.u);
    }
    for (int i = 0; i < a_.now.q_count + a_.now.u_count; ++i) through &= is_bounded(a_.now.q[i]);
    for (int i = 0; i < layout().rotor_speed.size; ++i) {
      through &= is_bounded(a_.rotors[kStepEnd][i].speed);
    }
    for (int i = 0; i < layout().joint_state.size; ++i) {
      through &= is_bounded(a_.joint_targets[kStepEnd][i]);
    }
    update_motion(a_.now.q, a_.now.u);
    if (all(through)) {  // the usual case, without reading the old values
      store_step(AllLanes());
    } else {
      store_step(through);
    }
    return through;
  }
  static SKYBODY_INLINE MaskOf<Real> is_bounded(const Real& x) { return abs(x) < kLargestState; }

  template <class Mask>
  SKYBODY_INLINE void store_step(const Mask& mask) {
    lanes_.store(a_.now.q, layout().q.size, mask, group_.q);
    lanes_.store(a_.now.u, layout().u.size, mask, group_.u);
    for (int i = 0; i < layout().rotor_speed.size; ++i) {
      lanes_.put(a_.rotors[kStepEnd][i].speed, mask, lanes_.at(group_.rotor_speed, i));
    }
    lanes_.store(a_.joint_targets[kStepEnd], layout().joint_state.size, mask, group_.joint_state);
    lanes_.store(reinterpret_cast<const Real*>(couplings_.coupling_forces()),
                 layout().coupling_forces.size, mask, group_.coupling_forces);
    put_motion(mask);
  }

  SKYBODY_INLINE void update_motion(const Real* q, const Real* u) {
    forward_kinematics(tree(), q, u, a_.motion);
  }

  template <class Mask>
  SKYBODY_INLINE void put_motion(const Mask& mask) {
    store_motion(0, body_count(), a_.motion, lanes_, mask, group_.bodies, spins_);
  }

  const StepPlan& plan_;
  const GroupBlocks& group_;
  double* spins_;
  LaneSlice<Real> lanes_;
  Values params_, derived_;
  Accelerations accelerations_;
  StepArrays<Real>& a_;
  StepActuators<Real, Values, kKind> actuators_;
  const SpatialForce<Real>* contact_ = nullptr;
  Couplings<Real> couplings_;
  HighSpinRobots<Real> fast_;
  MaskOf<Real> is_open_;       ///< lanes with a mean velocity that has not converged
  bool stays_ = false;         ///< all evaluations of the step are at the same q
  bool has_response_ = false;  ///< the response of couplings at this q is computed
  bool has_motion_ = false;    ///< `motion` belongs to the next point of evaluation
};

}  // namespace skybody
