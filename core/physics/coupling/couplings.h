// Constraints and springs between bodies, in the environments of one Real. On double and packs.
//
// Rods, ropes and points are equations for the accelerations of the points that they connect. Their
// forces are the multipliers of
//   A f = -(J udot + dJ/dt u)        A = J M^-1 J^T
// with J the derivative of the rows' gaps and udot the accelerations without couplings (R.
// Featherstone, Rigid Body Dynamics Algorithms, 2008, section 8.5). The tree's algorithms compute
// the columns of M^-1 J^T, one unit force after another. Rows that depend linearly on others have
// no pivot left and carry no force. A rope is an equation while it is taut and its force pulls.
//
// After a step, gaps and rates due to integration error are removed by the smallest change in the
// metric of the masses (M^-1 J^T again), so that momentum is conserved.
#pragma once

#include "core/physics/coupling/coupling_workspace.h"

namespace skybody {

enum class CouplingOperation { kBegin, kConstrain, kRelease, kProject };

/// Arguments of one operation on couplings.
template <class Real>
struct CouplingCall {
  const CouplingScene& scene;
  const MultibodyTree& multibody;
  const CouplingWorkspace<Real>& work;
  CouplingOperation operation;
  const Real *at_q = nullptr, *at_u = nullptr;
  Real *q = nullptr, *u = nullptr;  ///< for kProject
  const BodyKinematics<Real>* motion = nullptr;
  Real* udot = nullptr;
  bool is_same_place = false;
  Real dt{0.0};
  MaskOf<Real>* lanes = nullptr;
};

/// The code is long, so each width of packs has one function.
/// @param call  a CouplingCall with the number type of the width
using CouplingFunction = void(const void* call);

/// @param lanes  1: doubles; otherwise packs
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

  /// Loads the constants of this environment; clears the forces.
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

  /// Starts a step: finds the taut ropes.
  /// @param motion  at the start of the step
  SKYBODY_INLINE void begin(const Motion* motion) const {
    CouplingCall<Real> call = make_call(CouplingOperation::kBegin);
    call.motion = motion;
    run(call);
  }

  /// Corrects accelerations to satisfy the couplings, and computes the coupling forces.
  /// @param is_same_place  q is the same as in the last call
  /// @param udot           in: without couplings; out: with them
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

  /// Stores the forces and the active ropes of the last constrain().
  SKYBODY_INLINE void remember() const {
    for (std::size_t i = 0; i < scene_.constraints.size(); ++i) {
      w_.forces_before[i] = w_.coupling_forces[i];
      w_.held_before[i] = w_.was_held[i];
    }
  }
  /// Restores them in the lanes outside `mask`, for which constrain() has not been called since.
  SKYBODY_INLINE void take_back(const MaskOf<Real>& mask) const {
    for (std::size_t i = 0; i < scene_.constraints.size(); ++i) {
      w_.coupling_forces[i] = select(mask, w_.coupling_forces[i], w_.forces_before[i]);
      w_.was_held[i] = select(mask, w_.was_held[i], w_.held_before[i]);
    }
  }

  /// Removes the effect of the coupling forces from accelerations.
  SKYBODY_INLINE void release(const Real* q, const Motion* motion, Real* udot) const {
    CouplingCall<Real> call = make_call(CouplingOperation::kRelease);
    call.at_q = q;
    call.motion = motion;
    call.udot = udot;
    run(call);
  }

  /// Removes gaps and rates from q and u. Ropes with a force in the last constrain() are treated as
  /// rods; others are active if they are too long.
  /// @param dt  of the step, for the forces
  /// @returns the lanes with closed gaps; velocities of other lanes stay unchanged
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

  /// Adds the forces of rods, ropes and points from the last constrain().
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
  /// Per constraint: the lanes where its equations were active in the last constrain().
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
