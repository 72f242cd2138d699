#include "core/physics/coupling/couplings.h"

#include "core/base/simd/kernel_width.h"
#include "core/physics/coupling/coupling_equations.h"
#include "core/physics/coupling/coupling_response.h"

namespace skybody {
namespace {

/// Tolerance of gaps and rates [m], [m/s].
inline constexpr double kCouplingTolerance = 1e-10;
/// A rope is taut if its slack, and the rate of its slack, are at most this [m], [m/s].
inline constexpr double kTautTolerance = 1e-9;
/// Round-off of a gap, relative to the distance of the ends from W's origin.
inline constexpr double kGapRounding = 1e-14;

template <class Real>
class CouplingSolver {
 public:
  using Motion = BodyKinematics<Real>;

  SKYBODY_INLINE CouplingSolver(const CouplingScene& scene, const MultibodyTree& multibody,
                                const CouplingWorkspace<Real>& work)
      : scene_(scene), multibody_(multibody), w_(work) {}

  /// Starts a step: finds the taut ropes.
  /// @param motion  at the start of the step
  SKYBODY_INLINE void begin(const Motion* motion) const {
    place(motion);
    each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      w_.is_taut[i] = w_.is_there[i];
      if (constraint.kind == CouplingKind::kRope) {
        const CouplingRow<Real>& row = w_.rows[constraint.first_row];
        w_.is_taut[i] &= logical_and(row.gap >= -kTautTolerance, row.rate >= -kTautTolerance);
      }
    });
  }

  /// Corrects accelerations to satisfy the couplings, and computes the coupling forces.
  /// @param is_same_place  q is the same as in the last call
  /// @param udot           in: without couplings; out: with them
  SKYBODY_INLINE void constrain(const Real* q, const Real* u, const Motion* motion,
                                bool is_same_place, Real* udot) const {
    place(motion);
    if (!is_same_place) respond(q, motion);
    find_accelerations(q, u, udot, motion);
    each_row([&](int r, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      const CouplingRow<Real>& row = w_.rows[r];
      const Vec3<Real> apart = acceleration_at(constraint.ends[0], row.arm[0], motion) -
                               acceleration_at(constraint.ends[1], row.arm[1], motion);
      w_.equations.asked[r] = -(dot(row.out, apart) + row.bend);
    });
    each_constraint([&](int i, const CouplingConstraint&)
                        SKYBODY_INLINE_LAMBDA { w_.is_held[i] = w_.is_taut[i]; });
    solve([](int, const CouplingRow<Real>&) SKYBODY_INLINE_LAMBDA { return Real(0.0); });
    each_constraint([&](int i, const CouplingConstraint&)
                        SKYBODY_INLINE_LAMBDA { w_.was_held[i] = w_.is_held[i]; });
    add_change(udot);
    clear_coupling_forces();
    add_coupling_forces(Real(1.0));
  }

  /// Removes gaps and rates from q and u. Ropes with a force in the last constrain() are treated as
  /// rods; others are active if they are too long.
  /// @param dt  of the step, for the forces
  /// @returns the lanes where gaps are closed up to round-off
  SKYBODY_INLINE MaskOf<Real> project(const MaskOf<Real>& mask, const Real& dt, Real* q,
                                      Real* u) const {
    if (scene_.rope_count > 0) catch_ropes(mask, dt, q, u);
    const MaskOf<Real> is_closed = project_constraints(mask, q, u);
    stop_parting(is_closed, dt, q, u);
    return is_closed;
  }

  /// Removes the effect of the step's coupling forces from accelerations.
  SKYBODY_INLINE void release(const Real* q, const Motion* motion, Real* udot) const {
    place(motion);
    respond(q, motion);
    each_row([&](int r, const CouplingConstraint&) SKYBODY_INLINE_LAMBDA {
      w_.equations.force[r] = -dot(w_.rows[r].out, w_.coupling_forces[owner(r)]);
    });
    add_change(udot);
  }

 private:
  int row_count() const { return static_cast<int>(scene_.row_owners.size()); }
  int u_count() const { return scene_.world.layout.u.size; }
  int owner(int row) const { return scene_.row_owners[static_cast<std::size_t>(row)]; }

  /// Calls f(i, constraint) for constraints with equations.
  template <class F>
  SKYBODY_INLINE void each_constraint(const F& f) const {
    int i = 0;
    for (const CouplingConstraint& constraint : scene_.constraints) {
      if (constraint.row_count > 0) f(i, constraint);
      ++i;
    }
  }
  template <class F>
  SKYBODY_INLINE void each_row(const F& f) const {
    for (int r = 0; r < row_count(); ++r) {
      f(r, scene_.constraints[static_cast<std::size_t>(owner(r))]);
    }
  }
  /// Calls f(index, RobotLayout) for constrained robots.
  template <class F>
  SKYBODY_INLINE void each_robot(const F& f) const {
    int i = 0;
    for (const RobotLayout& robot : scene_.world.layout.robots) {
      if (scene_.is_held(i)) f(i, robot);
      ++i;
    }
  }
  /// Calls f(index, RobotLayout) for the one or two robots of a constraint.
  template <class F>
  SKYBODY_INLINE void each_robot_of(const CouplingConstraint& constraint, const F& f) const {
    const std::vector<RobotLayout>& robots = scene_.world.layout.robots;
    const int a = constraint.ends[0].robot, b = constraint.ends[1].robot;
    if (a >= 0) f(a, robots[static_cast<std::size_t>(a)]);
    if (b >= 0 && b != a) f(b, robots[static_cast<std::size_t>(b)]);
  }

  /// ---- positions of the ends

  /// Sets the rows: directions, gaps, rates.
  SKYBODY_INLINE void place(const Motion* motion) const {
    each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      const AttachmentMotion<Real> a(constraint.ends[0], motion), b(constraint.ends[1], motion);
      const Vec3<Real> apart = a.position - b.position, parting = a.velocity - b.velocity;
      const Real rounding = kCouplingTolerance + kGapRounding * norm(a.position);
      CouplingRow<Real>* row = w_.rows + constraint.first_row;
      if (constraint.kind == CouplingKind::kPoint) {
        const Real one(1.0), zero(0.0);
        row[0] = {{one, zero, zero}, {a.arm, b.arm}, apart.x, rounding, parting.x, zero};
        row[1] = {{zero, one, zero}, {a.arm, b.arm}, apart.y, rounding, parting.y, zero};
        row[2] = {{zero, zero, one}, {a.arm, b.arm}, apart.z, rounding, parting.z, zero};
        return;
      }
      const Real distance = norm(apart), per_length = 1.0 / max(distance, 1e-12);
      const Vec3<Real> out = apart * per_length;
      const Real rate = dot(out, parting);
      row[0] = {out,      {a.arm, b.arm}, distance - w_.lengths[i],
                rounding, rate,           (dot(parting, parting) - rate * rate) * per_length};
    });
  }

  SKYBODY_INLINE void find_accelerations(const Real* q, const Real* u, const Real* udot,
                                         const Motion* motion) const {
    each_robot([&](int, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      const int first = robot.first_body;
      const TreeBody& base = multibody_.bodies()[static_cast<std::size_t>(first)];
      if (robot.body_count == 1 && base.type == JointType::kFree && base.plain_body &&
          base.plain_parent) {
        w_.accelerations[first] = {load_vec3(udot + base.u), load_vec3(udot + (base.u + 3))};
        return;
      }
      body_accelerations(multibody_.bodies(), first, first + robot.body_count, q, u, udot, motion,
                         w_.accelerations);
    });
  }

  SKYBODY_INLINE Vec3<Real> acceleration_at(const Attachment& end, const Vec3<Real>& arm,
                                            const Motion* motion) const {
    if (end.body < 0) return SpatialForce<Real>::zero().force;
    const Motion& m = motion[end.body];
    const BodyAccelerationOf<Real>& a = w_.accelerations[end.body];
    const Vec3<Real>& w = m.angular_velocity;
    return a.linear + cross(m.axes * a.angular, arm) + cross(w, cross(w, arm));
  }

  /// ---- forces and their effects

  SKYBODY_INLINE void respond(const Real* q, const Motion* motion) const {
    respond_to_unit_forces(CouplingResponseCall<Real>{scene_, multibody_, w_, q, motion});
  }

  /// Computes the forces of the active rows for the required changes of rates. Ropes with more push
  /// than allowed are deactivated one by one, the largest push first.
  /// @param most_push  most_push(constraint's index, its row)
  template <class MostPush>
  SKYBODY_INLINE void solve(const MostPush& most_push) const {
#pragma GCC unroll 1
    for (int dropped = 0; dropped <= scene_.rope_count; ++dropped) {
      w_.equations.solve([&](int r) SKYBODY_INLINE_LAMBDA { return w_.is_held[owner(r)]; });
      if (scene_.rope_count == 0 || !let_go(most_push)) return;
    }
  }

  /// @returns whether any rope was deactivated
  template <class MostPush>
  SKYBODY_INLINE bool let_go(const MostPush& most_push) const {
    Real most(0.0), which(-1.0);
    each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      if (constraint.kind != CouplingKind::kRope) return;
      const int r = constraint.first_row;
      const Real push = w_.equations.force[r] - most_push(i, w_.rows[r]);
      const auto is_more = logical_and(w_.is_held[i], push > most);
      most = select(is_more, push, most);
      which = select(is_more, Real(static_cast<double>(i)), which);
    });
    if (none(which >= 0.0)) return false;
    each_constraint([&](int i, const CouplingConstraint&) SKYBODY_INLINE_LAMBDA {
      w_.is_held[i] &= which != Real(static_cast<double>(i));
    });
    return true;
  }

  /// Adds the effect of the forces to the rates of u, or of impulses to u.
  SKYBODY_INLINE void add_change(Real* of_u) const {
    each_row([&](int r, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      const Real* change = w_.change + r * u_count();
      each_robot_of(constraint, [&](int, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
        for (int i = robot.first_u; i < robot.first_u + robot.u_count; ++i) {
          of_u[i] += change[i] * w_.equations.force[r];
        }
      });
    });
  }

  SKYBODY_INLINE void clear_coupling_forces() const {
    each_constraint([&](int i, const CouplingConstraint&) SKYBODY_INLINE_LAMBDA {
      w_.coupling_forces[i] = SpatialForce<Real>::zero().force;
    });
  }
  SKYBODY_INLINE void add_coupling_forces(const Real& per_force) const {
    each_row([&](int r, const CouplingConstraint&) SKYBODY_INLINE_LAMBDA {
      w_.coupling_forces[owner(r)] += w_.rows[r].out * (w_.equations.force[r] * per_force);
    });
  }

  /// ---- errors after a step

  /// Largest value(row) of the active rows.
  template <class Value>
  SKYBODY_INLINE Real largest(const Value& value) const {
    Real most(-1.0);
    each_row([&](int r, const CouplingConstraint&) SKYBODY_INLINE_LAMBDA {
      most = max(most, select(w_.is_held[owner(r)], value(w_.rows[r]), Real(-1.0)));
    });
    return most;
  }

  SKYBODY_INLINE void move(const Real* q, const Real* u) const {
    each_robot([&](int, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      forward_kinematics(multibody_.bodies(), robot.first_body, robot.first_body + robot.body_count,
                         q, u, w_.motion);
    });
    place(w_.motion);
  }

  /// Handles ropes that became taut within the step, that is, were slack and are now too long. The
  /// bodies move back to that instant, are stopped there, and move on from it. Closing the gap by a
  /// shift instead would change the angular momentum.
  SKYBODY_INLINE void catch_ropes(const MaskOf<Real>& mask, const Real& dt, Real* q,
                                  Real* u) const {
    move(q, u);
    MaskOf<Real> is_caught(false);
    each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      w_.is_held[i] = w_.is_there[i];
      if (constraint.kind != CouplingKind::kRope) return;
      const CouplingRow<Real>& row = w_.rows[constraint.first_row];
      const auto is_long = logical_and(row.gap > row.rounding, row.rate > kCouplingTolerance);
      const auto is_new = logical_and(mask, logical_and(is_long, logical_not(w_.was_held[i])));
      w_.is_new[i] = logical_and(w_.is_held[i], is_new);
      is_caught |= w_.is_new[i];
      w_.is_held[i] &= logical_or(is_new, w_.was_held[i]);
    });
    if (none(is_caught)) return;
    keep_driven(q);
    Real ago(0.0);
    for (int k = 0; k < 3; ++k) {  // Newton's method: distances grow nearly linearly
      Real since(0.0);
      each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
        if (constraint.kind != CouplingKind::kRope) return;
        const CouplingRow<Real>& row = w_.rows[constraint.first_row];
        const auto counts = logical_and(w_.is_new[i], row.rate > kCouplingTolerance);
        since = max(since, select(counts, row.gap / select(counts, row.rate, Real(1.0)), since));
      });
      since = select(is_caught, min(since, dt - ago), Real(0.0));
      ago += since;
      drift(-since, is_caught, q, u);
      move(q, u);
    }
    respond(q, w_.motion);
    stop(is_caught, dt, u);
    drift(ago, is_caught, q, u);
    put_back_driven(q);
  }

  SKYBODY_INLINE void drift(const Real& time, const MaskOf<Real>& mask, Real* q,
                            const Real* u) const {
    for (int i = 0; i < u_count(); ++i) w_.shift[i] = time * u[i];
    shift(mask, q);
  }

  /// Driven bases move back with the other bodies, but must end at their drives' poses, to the bit:
  /// neither catch_ropes() nor closing a gap moves them.
  SKYBODY_INLINE void keep_driven(const Real* q) const {
    each_driven([&](Real* kept, int at, int count) SKYBODY_INLINE_LAMBDA {
      for (int k = 0; k < count; ++k) kept[k] = q[at + k];
    });
  }
  SKYBODY_INLINE void put_back_driven(Real* q) const {
    each_driven([&](const Real* kept, int at, int count) SKYBODY_INLINE_LAMBDA {
      for (int k = 0; k < count; ++k) q[at + k] = kept[k];
    });
  }
  /// Calls f(kept, first of its coordinates, their count) for driven bases.
  template <class F>
  SKYBODY_INLINE void each_driven(const F& f) const {
    Real* kept = w_.driven;
    for (const int body : scene_.driven) {
      const TreeBody& base = multibody_.bodies()[static_cast<std::size_t>(body)];
      f(kept, base.q, position_size(base.type));
      kept += 7;
    }
  }

  /// Projects the coordinates: Newton's method, per lane until its gaps are closed.
  /// @returns the lanes with closed gaps
  SKYBODY_INLINE MaskOf<Real> project_constraints(const MaskOf<Real>& mask, Real* q,
                                                  const Real* u) const {
    constexpr int kMostTries = 20;
    keep_driven(q);
    for (int left = kMostTries;; --left) {
      move(q, u);
      each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
        w_.is_held[i] = w_.is_there[i];
        if (constraint.kind != CouplingKind::kRope) return;
        const auto is_long = w_.rows[constraint.first_row].gap > 0.0;
        w_.is_held[i] &= logical_or(is_long, w_.was_held[i]);
      });
      const Real gap = largest([](const CouplingRow<Real>& row)
                                   SKYBODY_INLINE_LAMBDA { return abs(row.gap) - row.rounding; });
      const auto is_open = logical_and(mask, logical_not(gap <= 0.0));
      if (none(is_open) || left == 0) {
        note_open();
        return logical_and(mask, logical_not(is_open));
      }
      respond(q, w_.motion);
      each_row([&](int r, const CouplingConstraint&)
                   SKYBODY_INLINE_LAMBDA { w_.equations.asked[r] = -w_.rows[r].gap; });
      solve([](int, const CouplingRow<Real>&) SKYBODY_INLINE_LAMBDA { return Real(kInfinity); });
      for (int i = 0; i < u_count(); ++i) w_.shift[i] = Real(0.0);
      add_change(w_.shift);
      shift(is_open, q);
      put_back_driven(q);
    }
  }

  /// Records the constraints with open gaps.
  SKYBODY_INLINE void note_open() const {
    each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
      w_.is_open[i] = MaskOf<Real>(false);
      for (int r = constraint.first_row; r < constraint.first_row + constraint.row_count; ++r) {
        const CouplingRow<Real>& row = w_.rows[r];
        const auto is_closed = abs(row.gap) - row.rounding <= 0.0;
        w_.is_open[i] |= logical_and(w_.is_held[i], logical_not(is_closed));
      }
    });
  }

  SKYBODY_INLINE void shift(const MaskOf<Real>& mask, Real* q) const {
    each_robot([&](int, const RobotLayout& robot) SKYBODY_INLINE_LAMBDA {
      for (int i = robot.first_body; i < robot.first_body + robot.body_count; ++i) {
        const TreeBody& body = multibody_.bodies()[static_cast<std::size_t>(i)];
        Real moved[7];
        const int count = position_size(body.type);
        for (int k = 0; k < count; ++k) moved[k] = q[body.q + k];
        drift_position(body.type, Real(1.0), w_.shift + body.u, moved);
        normalize_position(body.type, moved);
        for (int k = 0; k < count; ++k) q[body.q + k] = select(mask, moved[k], q[body.q + k]);
      }
    });
  }

  /// Projects the velocities, at the positions that project_constraints() left. An impulse may
  /// tighten a rope that was at rest: it is handled in the next pass.
  SKYBODY_INLINE void stop_parting(const MaskOf<Real>& mask, const Real& dt, const Real* q,
                                   Real* u) const {
    constexpr int kMostPasses = 4;
#pragma GCC unroll 1
    for (int pass = 0; pass < kMostPasses; ++pass) {
      if (pass > 0) move(q, u);
      MaskOf<Real> is_parting(false);
      each_constraint([&](int i, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
        w_.is_held[i] = w_.is_there[i];
        if (constraint.kind != CouplingKind::kRope) return;
        const auto is_taut = w_.rows[constraint.first_row].gap >= -kTautTolerance;
        w_.is_held[i] &= logical_or(is_taut, w_.was_held[i]);
      });
      each_row([&](int r, const CouplingConstraint& constraint) SKYBODY_INLINE_LAMBDA {
        const Real& rate = w_.rows[r].rate;
        const bool is_rope = constraint.kind == CouplingKind::kRope;
        const auto slackens =
            logical_and(MaskOf<Real>(is_rope), logical_not(w_.was_held[owner(r)]));
        const Real wrong = select(slackens, rate, abs(rate));
        is_parting |= logical_and(w_.is_held[owner(r)], wrong > kCouplingTolerance);
      });
      is_parting &= mask;
      if (none(is_parting)) return;
      if (pass == 0) respond(q, w_.motion);
      stop(is_parting, dt, u);
    }
  }

  SKYBODY_INLINE void stop(const MaskOf<Real>& mask, const Real& dt, Real* u) const {
    each_row([&](int r, const CouplingConstraint&)
                 SKYBODY_INLINE_LAMBDA { w_.equations.asked[r] = -w_.rows[r].rate; });
    // A rope may give back at most its whole impulse of the step.
    solve([&](int i, const CouplingRow<Real>& row) SKYBODY_INLINE_LAMBDA {
      return max(-dot(w_.coupling_forces[i], row.out), Real(0.0)) * dt;
    });
    each_row([&](int r, const CouplingConstraint&) SKYBODY_INLINE_LAMBDA {
      w_.equations.force[r] = select(mask, w_.equations.force[r], Real(0.0));
    });
    for (int i = 0; i < u_count(); ++i) w_.shift[i] = u[i];
    add_change(w_.shift);
    for (int i = 0; i < u_count(); ++i) u[i] = select(mask, w_.shift[i], u[i]);
    add_coupling_forces(1.0 / dt);
  }

  const CouplingScene& scene_;
  const MultibodyTree& multibody_;
  CouplingWorkspace<Real> w_;
};

struct Work {
  template <int W>
  static SKYBODY_INLINE void run(const void* call) {
    using Real = RealOf<W>;
    const auto& c = *static_cast<const CouplingCall<Real>*>(call);
    const CouplingSolver<Real> solver(c.scene, c.multibody, c.work);
    switch (c.operation) {
      case CouplingOperation::kBegin:
        return solver.begin(c.motion);
      case CouplingOperation::kConstrain:
        return solver.constrain(c.at_q, c.at_u, c.motion, c.is_same_place, c.udot);
      case CouplingOperation::kRelease:
        return solver.release(c.at_q, c.motion, c.udot);
      case CouplingOperation::kProject:
        *c.lanes = solver.project(*c.lanes, c.dt, c.q, c.u);
    }
  }
};

}  // namespace

CouplingFunction* coupling_function(int lanes) { return width_function<Work>(lanes); }

}  // namespace skybody
