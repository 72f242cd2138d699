// Contact, applied as a correction after the step. First, any integrator takes the step without
// contact. If a pair may touch, the step is then repeated from its start in substeps of length h:
//   q moves for h/2 at u;  u += h (a + a_c(q, u));  q moves for h/2 at u
// with a the mean acceleration of the step without contact and a_c the accelerations by contact
// forces. Fast contacts take a second pass, with forces from mean velocities. Robots without a
// contact keep their uncorrected step, bit by bit.
//
// One code thus serves all integrators and both dynamics, and smooth forces are evaluated once for
// any number of substeps. This is a multiple-time-step leapfrog (M. Tuckerman, B. J. Berne, G. J.
// Martyna, "Reversible multiple time scale molecular dynamics", 1992, with the slow force spread
// evenly over the step). Bodies that spin fast, also due to a contact, drift by their torque-free
// motion (high_spin_robots.h), and a is the remaining acceleration. The same holds for all bodies
// with near pairs if springs are lossless.
#pragma once

#include <algorithm>
#include <type_traits>

#include "core/physics/step/correction_arrays.h"
#include "core/physics/step/equations_of_motion.h"

namespace skybody {

/// @tparam Values    access to parameters and to values derived from them
/// @tparam Response  computes the accelerations that forces on the bodies cause
/// @tparam Lanes     access to the lanes' values: a LaneSlice or LaneList
template <class Real, class Values, class Response = TreeResponse, class Lanes = LaneSlice<Real>>
class ContactSubsteps {
 public:
  /// @param lanes   the lanes of Real
  /// @param arrays  of the call's scratch memory
  SKYBODY_INLINE ContactSubsteps(const StepCall& call, const Lanes& lanes, const Values& params,
                                 const Values& derived, CorrectionArrays<Real>& arrays,
                                 const Response& response = {})
      : plan_(*call.plan),
        group_(*call.group),
        start_(call.start),
        near_(call.near),
        spins_(call.spins),
        lanes_(lanes),
        bodies_(derived + call.plan->derived.bodies),
        response_(response),
        a_(arrays),
        params_(params),
        couplings_(plan_.couplings, plan_.multibody, a_.couplings),
        fast_(plan_, a_.fast, a_.bodies, a_.mean),
        contact_(call.plan->contact, params + call.plan->world.layout.world_params, a_.bodies,
                 derived + call.plan->derived.obstacles, a_.contact) {}

  /// Corrects the step of the lanes in `mask`. Their values must be those at its end.
  /// @returns the lanes that succeeded; others keep the uncorrected step
  SKYBODY_INLINE MaskOf<Real> correct(const MaskOf<Real>& mask) {
    load(group_.q, group_.u, a_.end);
    start();
    forward_kinematics(tree(), a_.now.q, a_.now.u, a_.motion);
    const MaskOf<Real> is_near = contact_.search(a_.motion, [&](int m) SKYBODY_INLINE_LAMBDA {
      if (near_[m] == 0) return MaskOf<Real>(false);
      return logical_and(mask, mask_from_bits<Real>(lanes_.of_group(near_[m])));
    });
    find_near_robots();
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA { load_bodies(robot); });
    load_bristles();
    const double rate = 1.0 / dt();
    for (int i = 0; i < u_count(); ++i) {
      a_.smooth[i] = (a_.end.u[i] - a_.now.u[i]) * Real(rate);
      a_.no_forces[i] = Real(0.0);
    }
    contact_.cut_lossless();
    fast_.find(a_.motion, a_.is_robot_near, contact_.is_lossless());
    fast_.lock_all(a_.now);
    fast_.keep_mean_forces(dt(), a_.now, a_.end, a_.smooth);
    for (std::size_t i = 0; i < plan_.world.bodies.size(); ++i) {
      const Vec3<Real> zero = SpatialForce<Real>::zero().force;
      a_.at_rest[i].velocity = a_.at_rest[i].angular_velocity = a_.at_rest[i].spin = zero;
    }
    if (couplings_.any()) begin_couplings();
    go_through(is_near);
    return finish(is_near, mask);
  }

  /// Calls `list` for each contact of the current state (see ContactForces::act). Bristles stay
  /// unchanged.
  template <class List>
  SKYBODY_INLINE void each_contact(const List& list) {
    load(group_.q, group_.u, a_.now);
    forward_kinematics(tree(), a_.now.q, a_.now.u, a_.motion);
    contact_.search(a_.motion, [](int) SKYBODY_INLINE_LAMBDA { return MaskOf<Real>(true); });
    for (const RobotLayout& robot : plan_.world.layout.robots) load_bodies(robot);
    load_bristles();
    contact_.begin();
    contact_.act(a_.motion, a_.motion, Real(0.0), MaskOf<Real>(true), ContactPass::kStart, list);
  }
  /// Sum of the contact forces on each body, from the last each_contact().
  const SpatialForce<Real>* forces() const { return a_.contact.forces; }

 private:
  double dt() const { return plan_.world.scenario.stepping.dt; }
  const std::vector<TreeBody>& tree() const { return plan_.multibody.bodies(); }
  int u_count() const { return a_.now.u_count; }

  SKYBODY_INLINE void load(const double* q, const double* u, const Coordinates<Real>& to) const {
    lanes_.load(q, to.q_count, to.q);
    lanes_.load(u, to.u_count, to.u);
  }
  SKYBODY_INLINE void load_bodies(const RobotLayout& robot) const {
    const int first = kBodyConstantCount * robot.first_body;
    for (int k = first; k < first + kBodyConstantCount * robot.body_count; ++k) {
      a_.bodies[k] = bodies_[k];
    }
  }
  SKYBODY_INLINE void load_bristles() const {
    contact_.bristles().take([&](int i) SKYBODY_INLINE_LAMBDA {
      lanes_.load(lanes_.block(group_.bristles, 3 * i), 3,
                  reinterpret_cast<Real*>(a_.contact.bristles + i));
    });
  }

  /// Loads the step's start. Driven bases have the rates of their drives from there on.
  SKYBODY_INLINE void start() {
    load(start_.q, start_.u, a_.now);
    contact_.begin();
    for (const DrivenBase& drive : plan_.drives) {
      const TreeBody& base = tree()[static_cast<std::size_t>(drive.body)];
      for (int k = 0; k < velocity_size(base.type); ++k) {
        a_.now.u[base.u + k] = a_.end.u[base.u + k];
      }
    }
  }

  /// Starts the couplings. Removes their effect from the step's accelerations: they are recomputed.
  SKYBODY_INLINE void begin_couplings() {
    couplings_.load(params_, bodies_);
    lanes_.load(group_.coupling_forces, plan_.world.layout.coupling_forces.size,
                reinterpret_cast<Real*>(couplings_.coupling_forces()));
    couplings_.begin(a_.motion);
    couplings_.release(a_.now.q, a_.motion, a_.smooth);
  }

  SKYBODY_INLINE void go_through(const MaskOf<Real>& is_near) {
    Real parts = contact_.parts();
    forget_couplings();
#pragma GCC unroll 1
    for (int p = 0; p < kMaxContactSubsteps; ++p) {
      const auto is_active = logical_and(is_near, parts > static_cast<double>(p));
      if (none(is_active)) break;
      const Real step = Real(dt()) / parts, half = 0.5 * step;
      fast_.find_more(p == 0, a_.now, a_.is_robot_near);
      begin_part(half);
      if (!push(step, parts, is_active)) {  // a contact needs more substeps: restart with them
        parts = contact_.parts();
        begin_again(p == 0);
        p = -1;
        continue;
      }
      contact_.bristles().bend(is_active);
      end_part(step, half, is_active);
    }
  }

  /// @param is_first  the first substep has not ended: only coordinates have changed
  SKYBODY_INLINE void begin_again(bool is_first) {
    if (!is_first) {
      start();
      load_bristles();
      forget_couplings();
      return;
    }
    contact_.begin();
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      each_coordinate(robot, [&](int i) SKYBODY_INLINE_LAMBDA { a_.now.q[i] = a_.before.q[i]; });
    });
  }

  /// Moves coordinates by half a substep, and computes the motion there.
  SKYBODY_INLINE void begin_part(const Real& half) {
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      each_coordinate(robot, [&](int i) SKYBODY_INLINE_LAMBDA { a_.before.q[i] = a_.now.q[i]; });
    });
    drift(half);
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      const int last = robot.first_body + robot.body_count;
      forward_kinematics(tree(), robot.first_body, last, a_.now.q, a_.now.u, a_.motion);
      for (int i = robot.first_body; i < last; ++i) {
        a_.at_rest[i].position = a_.motion[i].position;
        a_.at_rest[i].rotation = a_.motion[i].rotation;
        a_.at_rest[i].axes = a_.motion[i].axes;
      }
    });
  }

  /// The response to the contacts of a substep.
  /// @returns false if a contact needs more substeps
  SKYBODY_INLINE bool push(const Real& step, const Real& parts, const MaskOf<Real>& is_active) {
    const BodyKinematics<Real>* mean = a_.motion;
#pragma GCC unroll 1
    for (const auto pass : {ContactPass::kStart, ContactPass::kMean, ContactPass::kLimited}) {
      const bool is_again = pass != ContactPass::kStart;
      contact_.act(a_.motion, mean, step, is_active, pass);
      const bool needs_limit =
          pass == ContactPass::kMean && any(logical_and(is_active, contact_.is_stiff()));
      if (needs_limit) continue;  // the next pass replaces these forces
      if (any(contact_.parts() > parts)) return false;
      response_(plan_, a_, is_again);
      each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
        for (int i = robot.first_u; i < robot.first_u + robot.u_count; ++i) {
          a_.rates[i] = a_.smooth[i] + a_.rates[i];
        }
      });
      if (couplings_.any()) {
        couplings_.constrain(a_.now.q, a_.now.u, a_.motion, is_again, a_.rates);
      }
      if (is_again) break;
      const auto is_quick = logical_and(is_active, contact_.is_quick());
      if (none(is_quick)) break;
      each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
        for (int i = robot.first_u; i < robot.first_u + robot.u_count; ++i) {
          const Real change = (0.5 * step) * a_.rates[i];
          a_.mean_u[i] = select(is_quick, a_.now.u[i] + change, a_.now.u[i]);
        }
        find_mean_motion(robot);
      });
      mean = a_.mean;
    }
    return true;
  }

  /// Computes the motion at the current positions with mean velocities.
  SKYBODY_INLINE void find_mean_motion(const RobotLayout& robot) const {
    const int first = robot.first_body;
    const TreeBody& base = tree()[static_cast<std::size_t>(first)];
    if (robot.body_count == 1 && base.type == JointType::kFree && base.plain_body) {
      a_.mean[first].position = a_.motion[first].position;
      a_.mean[first].velocity = load_vec3(a_.mean_u + base.u);
      a_.mean[first].angular_velocity = a_.motion[first].axes * load_vec3(a_.mean_u + (base.u + 3));
      return;
    }
    forward_kinematics(tree(), first, first + robot.body_count, a_.now.q, a_.mean_u, a_.mean);
  }

  /// Updates velocities, and moves coordinates by the other half.
  SKYBODY_INLINE void end_part(const Real& step, const Real& half, const MaskOf<Real>& is_active) {
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      for (int i = robot.first_u; i < robot.first_u + robot.u_count; ++i) {
        a_.now.u[i] += step * a_.rates[i];
      }
    });
    drift(half);
    if (couplings_.any()) project(step, is_active);
    if (all(is_active)) return;
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      each_coordinate(robot, [&](int i) SKYBODY_INLINE_LAMBDA {
        a_.now.q[i] = select(is_active, a_.now.q[i], a_.before.q[i]);
      });
    });
  }

  SKYBODY_INLINE void project(const Real& step, const MaskOf<Real>& is_active) {
    couplings_.project(is_active, step, a_.now.q, a_.now.u);
    for (std::size_t i = 0; i < plan_.couplings.constraints.size(); ++i) {
      a_.has_opened[i] |= logical_and(is_active, couplings_.open()[i]);
      const Vec3<Real> more = couplings_.coupling_forces()[i] * (step * (1.0 / dt()));
      a_.coupling_forces[i] =
          select(is_active, a_.coupling_forces[i] + more, a_.coupling_forces[i]);
    }
  }
  SKYBODY_INLINE void forget_couplings() const {
    for (std::size_t i = 0; i < plan_.couplings.constraints.size(); ++i) {
      a_.coupling_forces[i] = SpatialForce<Real>::zero().force;
      a_.has_opened[i] = MaskOf<Real>(false);
    }
  }
  /// Lanes in which a coupling with corrected coordinates has an open gap.
  SKYBODY_INLINE MaskOf<Real> is_torn() const {
    MaskOf<Real> is_torn(false);
    each_equation([&](std::size_t i, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      is_torn |= logical_and(a_.has_opened[i], is_touched(robot));
    });
    return is_torn;
  }
  /// Calls f(i, robot) for couplings with equations, with one of their robots.
  template <class F>
  SKYBODY_INLINE void each_equation(const F& f) const {
    for (std::size_t i = 0; i < plan_.couplings.constraints.size(); ++i) {
      const CouplingConstraint& constraint = plan_.couplings.constraints[i];
      if (constraint.row_count == 0) continue;
      const int robot = std::max(constraint.ends[0].robot, constraint.ends[1].robot);
      if (!a_.is_robot_near[robot]) continue;
      f(i, plan_.world.layout.robots[static_cast<std::size_t>(robot)]);
    }
  }

  /// Calls f(robot) for robots with a near pair in any lane.
  template <class F>
  SKYBODY_INLINE void each_near_robot(const F& f) const {
    const bool* is_near = a_.is_robot_near;
    for (const RobotLayout& robot : plan_.world.layout.robots) {
      if (*is_near++) f(robot);
    }
  }
  SKYBODY_INLINE void find_near_robots() {
    for (std::size_t r = 0; r < plan_.world.layout.robots.size(); ++r) a_.is_robot_near[r] = false;
    for (std::size_t i = 0; i < plan_.contact.bodies.size(); ++i) {
      a_.is_robot_near[plan_.contact.bodies[i].robot] |= any(a_.contact.is_body_near[i]);
    }
    // All couplings of a lane are solved together. Constrained robots are always included, wherever
    // in the pack a pair is near, so that each lane has the same result as when computed alone.
    for (std::size_t r = 0; r < plan_.couplings.held_with.size(); ++r) {
      a_.is_robot_near[r] |= plan_.couplings.is_held(static_cast<int>(r));
    }
  }
  /// Calls f(i) for the indices of q and of u, which are contiguous.
  template <class F>
  SKYBODY_INLINE void each_coordinate(const RobotLayout& robot, const F& f) const {
    for (int i = robot.first_q; i < robot.first_q + robot.q_count; ++i) f(i);
    const int first_u = a_.now.q_count + robot.first_u;
    for (int i = first_u; i < first_u + robot.u_count; ++i) f(i);
  }
  SKYBODY_INLINE void drift(const Real& time) const {
    fast_.drift(time, false, a_.now, [&]() SKYBODY_INLINE_LAMBDA {
      each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA { drift(robot, time); });
    });
  }
  SKYBODY_INLINE void drift(const RobotLayout& robot, const Real& time) const {
    for (int i = robot.first_body; i < robot.first_body + robot.body_count; ++i) {
      const TreeBody& body = tree()[static_cast<std::size_t>(i)];
      drift_position(body.type, time, a_.now.u + body.u, a_.now.q + body.q);
      normalize_position(body.type, a_.now.q + body.q);
    }
  }

  /// Writes the corrected coordinates of touched robots, in lanes where all of these are bounded.
  SKYBODY_INLINE MaskOf<Real> finish(const MaskOf<Real>& is_near, const MaskOf<Real>& mask) {
    for (const DrivenBase& drive : plan_.drives) {
      const TreeBody& base = tree()[static_cast<std::size_t>(drive.body)];
      for (int k = 0; k < position_size(base.type); ++k) {
        a_.now.q[base.q + k] = a_.end.q[base.q + k];
      }
    }
    MaskOf<Real> through = mask;
    if (couplings_.any()) through &= logical_not(is_torn());
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      MaskOf<Real> is_bounded(true);
      each_coordinate(robot, [&](int i) SKYBODY_INLINE_LAMBDA {
        is_bounded &= abs(a_.now.q[i]) < kLargestState;
      });
      through &= logical_or(is_bounded, logical_not(is_touched(robot)));
    });
    contact_.bristles().each_busy([&](int i) SKYBODY_INLINE_LAMBDA {
      lanes_.store(reinterpret_cast<const Real*>(a_.contact.bristles + i), 3, through & is_near,
                   lanes_.block(group_.bristles, 3 * i));
    });
    each_near_robot([&](const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      const auto corrected = logical_and(through, is_touched(robot));
      if (!none(corrected)) store(robot, corrected);
    });
    if (couplings_.any()) store_coupling_forces(through);
    return through;
  }

  SKYBODY_INLINE void store_coupling_forces(const MaskOf<Real>& mask) const {
    each_equation([&](std::size_t i, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      lanes_.store(reinterpret_cast<const Real*>(a_.coupling_forces + i), 3,
                   logical_and(mask, is_touched(robot)),
                   lanes_.block(group_.coupling_forces, 3 * static_cast<int>(i)));
    });
  }

  SKYBODY_INLINE MaskOf<Real> is_touched(const RobotLayout& robot) const {
    MaskOf<Real> any_body(false);
    const auto add = [&](const RobotLayout& one) SKYBODY_INLINE_LAMBDA {
      for (int i = 0; i < one.body_count; ++i) {
        any_body |= a_.contact.is_touched[one.first_body + i];
      }
    };
    const auto index = static_cast<std::size_t>(&robot - plan_.world.layout.robots.data());
    const std::vector<int>& held_with = plan_.couplings.held_with;
    if (held_with[index] < 0) {
      add(robot);
      return any_body;
    }
    for (std::size_t r = 0; r < held_with.size(); ++r) {  // connected robots move together
      if (held_with[r] == held_with[index]) add(plan_.world.layout.robots[r]);
    }
    return any_body;
  }

  SKYBODY_INLINE void store(const RobotLayout& robot, const MaskOf<Real>& mask) {
    const int first = robot.first_body, last = first + robot.body_count;
    for (int i = first; i < last; ++i) {
      const TreeBody& body = tree()[static_cast<std::size_t>(i)];
      normalize_position(body.type, a_.now.q + body.q);
    }
    lanes_.store(a_.now.q + robot.first_q, robot.q_count, mask,
                 lanes_.block(group_.q, robot.first_q));
    lanes_.store(a_.now.u + robot.first_u, robot.u_count, mask,
                 lanes_.block(group_.u, robot.first_u));
    forward_kinematics(tree(), first, last, a_.now.q, a_.now.u, a_.motion);
    store_motion(first, last, a_.motion, lanes_, mask, group_.bodies, spins_);
  }

  const StepPlan& plan_;
  const GroupBlocks& group_;
  StepStart start_;
  std::uint32_t* near_;
  double* spins_;
  Lanes lanes_;
  Values bodies_;
  Response response_;
  CorrectionArrays<Real>& a_;
  Values params_;
  Couplings<Real> couplings_;
  HighSpinRobots<Real> fast_;
  ContactForces<Real, Values> contact_;
};

}  // namespace skybody
