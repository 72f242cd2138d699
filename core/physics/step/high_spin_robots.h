// Robots that spin fast (fast_spin_square in integration_rules.h), in the environments of one Real.
// Their bases drift by the torque-free motion of the robot with locked joints, and the rates of
// that motion are subtracted from the accelerations. The remaining accelerations are small and may
// be evaluated in mid-step. On double, packs and dual numbers.
#pragma once

#include "core/physics/bodies/torque_free.h"
#include "core/physics/step/step_plan.h"
#include "core/physics/tree/locked_body.h"

namespace skybody {

/// One robot of the world.
template <class Real>
struct HighSpinRobot {
  MaskOf<Real> mask;      ///< lanes in which it is fast
  MaskOf<Real> at_start;  ///< lanes in which it was fast at the start of the step
  bool has_any;           ///< `mask` is not empty
  LockedBody<Real> body;
  Real base[13];  ///< q and u of its base, during a move
};

/// Robots with joints and a spin above fast_spin_square take a step in substeps, because motion at
/// joints is not torque-free. The mean angle per substep is at most this one from kFastPartSpin on;
/// at lower spins the angle grows as 1 / spin (0.05 rad at 30 rad/s).
inline constexpr double kFastPartAngle = 0.015;  // [rad]
inline constexpr double kFastPartSpin = 100.0;   // [rad/s]
/// If one substep is not enough, substeps are in groups of five: four forward with the first share
/// of the time and one backward with the second. Their errors of third order cancel (M. Suzuki,
/// "Fractal decomposition of exponential operators", Physics Letters A 146, 1990: order 4 from any
/// symmetric step of order 2). With couplings all substeps are equal: the effect of a rope cannot
/// be undone.
inline constexpr int kFastPartGroup = 5;
inline constexpr double kFastPartShare = 0.4144907717943757;  // 1 / (4 - cbrt(4))
inline constexpr double kFastPartShareBack = 1.0 - 4.0 * kFastPartShare;
/// Maximum number of substeps: faster robots rotate by a larger angle in each.
inline constexpr int kMostFastParts = 130;

template <class Real>
class HighSpinRobots {
 public:
  /// @param robots     one per robot of the world
  /// @param constants  kBodyConstantCount values per body, of fast robots
  /// @param motion     one per body, overwritten
  SKYBODY_INLINE HighSpinRobots(const StepPlan& plan, HighSpinRobot<Real>* robots,
                                const Real* constants, BodyKinematics<Real>* motion)
      : plan_(plan), robots_(robots), constants_(constants), motion_(motion) {}

  /// Finds the fast robots at the step's start.
  /// @param motion     of all bodies
  /// @param is_wanted  per robot: skips the others; null: skips none
  /// @param always     lanes in which all robots that are not skipped count as fast
  SKYBODY_INLINE void find(const BodyKinematics<Real>* motion, const bool* is_wanted = nullptr,
                           const MaskOf<Real>& always = MaskOf<Real>(false)) {
    has_any_ = has_more_ = false;
    jointed_square_ = Real(0.0);
    int r = 0;
    for (const RobotLayout& robot : plan_.world.layout.robots) {
      HighSpinRobot<Real>& fast = robots_[r];
      Real square(0.0);
      const bool is_here = is_wanted == nullptr || is_wanted[r];
      for (int i = 0; is_here && i < robot.body_count; ++i) {
        square = max(square, squared_norm(motion[robot.first_body + i].spin));
      }
      const auto counts = logical_and(always, MaskOf<Real>(is_here));
      fast.mask = fast.at_start = logical_or(square > plan_.fast_square, counts);
      fast.has_any = any(fast.mask);
      has_any_ |= fast.has_any;
      if (robot.body_count > 1) jointed_square_ = max(jointed_square_, square);
      ++r;
    }
  }

  /// Adds robots whose bases have become fast within the step.
  /// @param is_first   the step starts or restarts: back to the robots from find()
  /// @param is_wanted  per robot: skips the others
  template <class Coordinates>
  SKYBODY_INLINE void find_more(bool is_first, const Coordinates& at, const bool* is_wanted) {
    if (is_first) return forget_more();
    int r = -1;
    for (const RobotLayout& robot : plan_.world.layout.robots) {
      if (!is_wanted[++r] || !plan_.multibody.floats(r)) continue;
      HighSpinRobot<Real>& fast = robots_[r];
      const auto is_fast = squared_norm(load_vec3(at.u + (robot.first_u + 3))) > plan_.fast_square;
      const auto is_new = logical_and(is_fast, logical_not(fast.mask));
      if (none(is_new)) continue;
      const LockedBody<Real> before = fast.body;
      lock_joints(robot, at, fast);
      fast.body = select(is_new, fast.body, before);
      fast.mask |= is_new;
      fast.has_any = has_any_ = has_more_ = true;
    }
  }

  /// Restarts the step with the robots from find().
  SKYBODY_INLINE void forget_more() {
    if (!has_more_) return;
    has_any_ = has_more_ = false;
    for (std::size_t r = 0; r < plan_.world.layout.robots.size(); ++r) {
      robots_[r].mask = robots_[r].at_start;
      robots_[r].has_any = any(robots_[r].mask);
      has_any_ |= robots_[r].has_any;
    }
  }

  /// Subtracts the effect of drift() on the velocities from the mean accelerations of a step by any
  /// integrator. @param from, to  the step's start and end
  template <class Coordinates>
  SKYBODY_INLINE void keep_mean_forces(double dt, const Coordinates& from, const Coordinates& to,
                                       Real* udot) const {
    if (!has_any_) return;
    each_base([&](HighSpinRobot<Real>& fast, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      take_base(robot, from, fast);
      move(fast, Real(0.5 * dt));
      Real before[6];
      for (int k = 0; k < 6; ++k) before[k] = fast.base[7 + k];
      take_base(robot, to, fast);
      move(fast, Real(-0.5 * dt));
      const double rate = 1.0 / dt;
      for (int k = 0; k < 6; ++k) {
        Real& mean = udot[robot.first_u + k];
        mean = select(fast.mask, (fast.base[7 + k] - before[k]) * rate, mean);
      }
    });
  }
  bool has_any() const { return has_any_; }
  /// Lanes with a fast robot with joints: one evaluation in mid-step is not enough there.
  SKYBODY_INLINE MaskOf<Real> iterates() const { return jointed_square_ > plan_.fast_square; }
  /// Number of substeps of the step: 1 in lanes where one is enough; else a multiple of five, or
  /// any number with couplings.
  SKYBODY_INLINE Real parts(double dt) const {
    const double group = goes_back() ? kFastPartGroup : 1;
    const Real spin = sqrt(jointed_square_);
    const Real share = min(spin * (1.0 / kFastPartSpin), Real(1.0));
    const Real wanted = spin * share * (dt / kFastPartAngle);
    const Real groups = clamp(floor(wanted * (1.0 / group)) + 1.0, 1.0, kMostFastParts / group);
    return select(logical_and(iterates(), wanted > 1.0), group * groups, Real(1.0));
  }
  /// The time of one substep; negative for the backward one. @param part  its index, from 0
  SKYBODY_INLINE Real part_time(double dt, const Real& parts, int part) const {
    const Real mean = Real(dt) / parts;
    if (!goes_back()) return mean;
    const bool is_back = part % kFastPartGroup == kFastPartGroup / 2;
    const double share = kFastPartGroup * (is_back ? kFastPartShareBack : kFastPartShare);
    return select(parts > 1.0, share * mean, mean);
  }

  /// Calls f(robot) for robots that are fast in any lane.
  template <class F>
  SKYBODY_INLINE void each_robot(const F& f) const {
    const HighSpinRobot<Real>* fast = robots_;
    for (const RobotLayout& robot : plan_.world.layout.robots) {
      if (fast++->has_any) f(robot);
    }
  }

  /// Locks the joints at their current positions, for drift() and subtract_torque_free_rates().
  template <class Coordinates>
  SKYBODY_INLINE void lock_all(const Coordinates& at) const {
    if (!has_any_) return;
    each_base([&](HighSpinRobot<Real>& fast, const RobotLayout& robot)
                  SKYBODY_INLINE_LAMBDA { lock_joints(robot, at, fast); });
  }

  /// Moves all robots for a time without forces.
  /// @param locks   locks the joints at their positions after slowly(), also for later calls
  /// @param slowly  slowly() moves the robots as if none were fast
  template <class Coordinates, class Slowly>
  SKYBODY_INLINE void drift(const Real& time, bool locks, const Coordinates& at,
                            const Slowly& slowly) const {
    if (!has_any_) return slowly();
    each_base([&](HighSpinRobot<Real>& fast, const RobotLayout& robot)
                  SKYBODY_INLINE_LAMBDA { take_base(robot, at, fast); });
    slowly();
    each_base([&](HighSpinRobot<Real>& fast, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      if (locks) lock_joints(robot, at, fast);
      move(fast, time);
      for (int k = 0; k < 7; ++k) {
        Real& q = at.q[robot.first_q + k];
        q = select(fast.mask, fast.base[k], q);
      }
      for (int k = 0; k < 6; ++k) {
        Real& u = at.u[robot.first_u + k];
        u = select(fast.mask, fast.base[7 + k], u);
      }
    });
  }

  /// Subtracts the effect of drift() on the velocities from accelerations.
  /// @param motion  of all bodies
  SKYBODY_INLINE void subtract_torque_free_rates(const BodyKinematics<Real>* motion, const Real* u,
                                                 Real* udot) const {
    if (!has_any_) return;
    each_base([&](const HighSpinRobot<Real>& fast, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      Vec3<Real> own[2];
      own[1] = fast.body.spin_rates(motion[robot.first_body].axes,
                                    load_vec3(u + (robot.first_u + 3)), own[0]);
      const Real* const rates = &own[0].x;
      for (int k = 0; k < 6; ++k) {
        Real& rate = udot[robot.first_u + k];
        rate = select(fast.mask, rate - rates[k], rate);
      }
    });
  }

 private:
  bool goes_back() const { return plan_.couplings.constraints.empty(); }

  /// Calls f(fast, robot) for fast robots with a floating base.
  template <class F>
  SKYBODY_INLINE void each_base(const F& f) const {
    int r = 0;
    for (const RobotLayout& robot : plan_.world.layout.robots) {
      if (robots_[r].has_any && plan_.multibody.floats(r)) f(robots_[r], robot);
      ++r;
    }
  }

  template <class Coordinates>
  static SKYBODY_INLINE void take_base(const RobotLayout& robot, const Coordinates& from,
                                       HighSpinRobot<Real>& fast) {
    for (int k = 0; k < 7; ++k) fast.base[k] = from.q[robot.first_q + k];
    for (int k = 0; k < 6; ++k) fast.base[7 + k] = from.u[robot.first_u + k];
  }

  template <class Coordinates>
  SKYBODY_INLINE void lock_joints(const RobotLayout& robot, const Coordinates& at,
                                  HighSpinRobot<Real>& fast) const {
    fast.body = lock(plan_.multibody.bodies(), robot.first_body,
                     robot.first_body + robot.body_count, constants_, at.q, at.u, motion_);
  }

  static SKYBODY_INLINE void move(HighSpinRobot<Real>& fast, const Real& time) {
    Real* const b = fast.base;
    Vec3<Real> position = load_vec3(b), velocity = load_vec3(b + 7), spin = load_vec3(b + 10);
    Quat<Real> rotation = load_quat(b + 3);
    move_freely(TorqueFreeCall<Real>{fast.body.inertia, fast.body.com, time, fast.mask, position,
                                     rotation, velocity, spin});
    store(position, b);
    store(rotation, b + 3);
    store(velocity, b + 7);
    store(spin, b + 10);
  }

  const StepPlan& plan_;
  HighSpinRobot<Real>* robots_;
  const Real* constants_;
  BodyKinematics<Real>* motion_;
  Real jointed_square_ = Real(0.0);  ///< largest spin of the robots with joints, squared
  bool has_any_ = false;
  bool has_more_ = false;  ///< some robots have become fast within the step
};

}  // namespace skybody
