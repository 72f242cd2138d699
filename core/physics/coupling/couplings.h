// What holds bodies together, in the environments that one Real holds. On double and packs.
//
// Rods, ropes and points are equations for the accelerations of the points that they join. Their
// forces are the multipliers of
//   A f = -(J udot + dJ/dt u)        A = J M^-1 J^T
// with J the derivative of the rows' gaps and udot the accelerations without them (R. Featherstone,
// Rigid Body Dynamics Algorithms, 2008, section 8.5). Columns of M^-1 J^T are found by the tree's
// algorithms, one unit force after the other. Rows that others follow from have no pivot left and
// carry nothing. A rope is an equation while it is taut and pulls.
//
// What a step's own error leaves of gaps and rates is taken away after it, by the least change that
// the masses allow (M^-1 J^T again), so that momentum is kept.
#pragma once

#include "core/physics/coupling/coupling_workspace.h"

namespace skybody {

enum class CouplingOperation { kBegin, kConstrain, kRelease, kProject };

/// What couplings are to do.
template <class Real>
struct CouplingCall {
  const CouplingScene& scene;
  const MultibodyTree& multibody;
  const CouplingWorkspace<Real>& work;
  CouplingOperation operation;
  const Real *at_q = nullptr, *at_u = nullptr;
  Real *q = nullptr, *u = nullptr;  ///< of kProject
  const BodyKinematics<Real>* motion = nullptr;
  Real* udot = nullptr;
  bool is_same_place = false;
  Real dt{0.0};
  MaskOf<Real>* lanes = nullptr;
};

/// One function for each width of packs, since its code is long.
/// @param call  a CouplingCall of the width's type of number
using CouplingFunction = void(const void* call);

/// @param lanes  1: of doubles; else of packs
CouplingFunction* coupling_function(int lanes);

template <class Real>
class Couplings {
 public:
  using Motion = BodyKinematics<Real>;

  SKYBODY_INLINE Couplings(const CouplingScene& scene, const MultibodyTree& multibody,
                           const CouplingWorkspace<Real>& work)
      : scene_(scene), multibody_(multibody), w_(work) {}

  /// Whether there are any equations.
  bool any() const { return !scene_.row_owners.empty(); }

  /// The constants of this environment. Nothing has pulled so far.
  /// @param params  the parameter block; @param bodies  kBodyConstantCount values per body: each a
  ///                pointer, or a view (lane_values.h)
  template <class Values>
  SKYBODY_INLINE void load(const Values& params, const Values& bodies) const {
    const Vec3<Real> zero = SpatialForce<Real>::zero().force;
    const std::vector<RobotLayout>& robots = scene_.world.layout.robots;
    for (std::size_t r = 0; r < robots.size(); ++r) {
      if (!scene_.is_held(static_cast<int>(r))) continue;
      const int first = kBodyConstantCount * robots[r].first_body;
      for (int k = first; k < first + kBodyConstantCount * robots[r].body_count; ++k) {
        w_.bodies[k] = bodies[k];
      }
    }
    for (int i = 0; i < scene_.world.layout.u.size; ++i) w_.nothing[i] = Real(0.0);
    int i = -1;
    for (const CouplingConstraint& constraint : scene_.constraints) {
      w_.coupling_forces[++i] = zero;
      w_.is_open[i] = MaskOf<Real>(false);
      w_.is_there[i] = Real(params[constraint.params + kCouplingPresent]) != 0.0;
      w_.was_held[i] =
          constraint.kind == CouplingKind::kRope ? MaskOf<Real>(false) : w_.is_there[i];
      if (constraint.kind != CouplingKind::kPoint) {
        w_.lengths[i] = params[constraint.params + kCouplingLength];
      }
    }
  }

  /// A step begins: which ropes are taut.
  /// @param motion  at its start
  SKYBODY_INLINE void begin(const Motion* motion) const {
    CouplingCall<Real> call = make_call(CouplingOperation::kBegin);
    call.motion = motion;
    run(call);
  }

  /// Makes accelerations what the couplings allow; and the forces that do it.
  /// @param is_same_place  q is as in the last call
  /// @param udot           without couplings; overwritten
  SKYBODY_INLINE void constrain(const Real* q, const Real* u, const Motion* motion,
                                bool is_same_place, Real* udot) const {
    CouplingCall<Real> call = make_call(CouplingOperation::kConstrain);
    call.at_q = q;
    call.at_u = u;
    call.motion = motion;
    call.is_same_place = is_same_place;
    call.udot = udot;
    run(call);
  }

  /// Keeps pulls and ropes as the last constrain() left them.
  SKYBODY_INLINE void remember() const {
    for (std::size_t i = 0; i < scene_.constraints.size(); ++i) {
      w_.forces_before[i] = w_.coupling_forces[i];
      w_.held_before[i] = w_.was_held[i];
    }
  }
  /// Takes them back in the lanes that are not in `mask`: in these, nothing was asked since.
  SKYBODY_INLINE void take_back(const MaskOf<Real>& mask) const {
    for (std::size_t i = 0; i < scene_.constraints.size(); ++i) {
      w_.coupling_forces[i] = select(mask, w_.coupling_forces[i], w_.forces_before[i]);
      w_.was_held[i] = select(mask, w_.was_held[i], w_.held_before[i]);
    }
  }

  /// Takes from accelerations what the pulls did to them.
  SKYBODY_INLINE void release(const Real* q, const Motion* motion, Real* udot) const {
    CouplingCall<Real> call = make_call(CouplingOperation::kRelease);
    call.at_q = q;
    call.motion = motion;
    call.udot = udot;
    run(call);
  }

  /// Takes gaps and rates away from q and u. Ropes that pulled in the last constrain() are as rods
  /// here; others are held where they are too long.
  /// @param dt  of the step, for the pulls
  /// @returns the lanes where no gap is left; the velocities of others stay
  SKYBODY_INLINE MaskOf<Real> project(const MaskOf<Real>& mask, const Real& dt, Real* q,
                                      Real* u) const {
    MaskOf<Real> lanes = mask;
    CouplingCall<Real> call = make_call(CouplingOperation::kProject);
    call.q = q;
    call.u = u;
    call.dt = dt;
    call.lanes = &lanes;
    run(call);
    return lanes;
  }

  /// Adds the forces of springs.
  /// @param params  the parameter block: a pointer, or a view
  template <class Values>
  SKYBODY_INLINE void add_springs(const Values& params, const Motion* motion,
                                  SpatialForce<Real>* forces) const {
    int i = -1;
    for (const CouplingConstraint& constraint : scene_.constraints) {
      ++i;
      if (constraint.kind != CouplingKind::kSpring) continue;
      const Values constants = params + constraint.params;
      const AttachmentMotion<Real> a(constraint.ends[0], motion), b(constraint.ends[1], motion);
      const Vec3<Real> apart = a.position - b.position;
      const Real distance = norm(apart);
      const Vec3<Real> out = apart * (1.0 / max(distance, 1e-12));
      const Real pull = constants[kCouplingStiffness] * (distance - w_.lengths[i]) +
                        constants[kCouplingDamping] * dot(out, a.velocity - b.velocity);
      const Real zero(0.0);
      const Vec3<Real> force = select(w_.is_there[i], -(out * pull), {zero, zero, zero});
      w_.coupling_forces[i] = force;
      if (constraint.ends[0].body >= 0) forces[constraint.ends[0].body].add_force_at(a.arm, force);
      if (constraint.ends[1].body >= 0) forces[constraint.ends[1].body].add_force_at(b.arm, -force);
    }
  }

  /// Adds the forces of rods, ropes and points, as the last constrain() found them.
  SKYBODY_INLINE void add_coupling_forces(const Motion* motion, SpatialForce<Real>* forces) const {
    int i = -1;
    for (const CouplingConstraint& constraint : scene_.constraints) {
      ++i;
      if (constraint.kind == CouplingKind::kSpring) continue;
      for (int e = 0; e < 2; ++e) {
        const Attachment& end = constraint.ends[static_cast<std::size_t>(e)];
        if (end.body < 0) continue;
        const AttachmentMotion<Real> at(end, motion);
        forces[end.body].add_force_at(at.arm,
                                      e == 0 ? w_.coupling_forces[i] : -w_.coupling_forces[i]);
      }
    }
  }

  /// Per constraint: the force on its first end, W [N].
  Vec3<Real>* coupling_forces() const { return w_.coupling_forces; }
  /// Per constraint: the lanes where the last project() left its gap open.
  const MaskOf<Real>* open() const { return w_.is_open; }
  /// Per constraint: the lanes where its equations held in the last constrain().
  const MaskOf<Real>* held() const { return w_.was_held; }

 private:
  SKYBODY_INLINE CouplingCall<Real> make_call(CouplingOperation operation) const {
    return {scene_, multibody_, w_, operation};
  }
  static SKYBODY_INLINE void run(const CouplingCall<Real>& call) {
    coupling_function(kLanesOf<Real>)(&call);
  }

  const CouplingScene& scene_;
  const MultibodyTree& multibody_;
  CouplingWorkspace<Real> w_;
};

}  // namespace skybody
