// Work arrays for the couplings of one environment or pack, in a thread's scratch memory.
#pragma once

#include "core/physics/bodies/body_accelerations.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/coupling/coupling_equations.h"
#include "core/physics/coupling/coupling_scene.h"
#include "core/physics/tree/multibody_tree.h"

namespace skybody {

/// Position and velocity of an end, W.
template <class Real>
struct AttachmentMotion {
  Vec3<Real> arm;       ///< from its body's origin [m]
  Vec3<Real> position;  ///< [m]
  Vec3<Real> velocity;  ///< [m/s]

  SKYBODY_INLINE AttachmentMotion(const Attachment& end, const BodyKinematics<Real>* motion) {
    const Vec3<Real> point = to_real<Real>(end.point);
    arm = velocity = SpatialForce<Real>::zero().force;
    position = point;
    if (end.body < 0) return;
    const BodyKinematics<Real>& m = motion[end.body];
    arm = m.axes * point;
    position = m.position + arm;
    velocity = m.velocity + cross(m.angular_velocity, arm);
  }
};

/// One equation: a condition on the distance between two points along a direction.
template <class Real>
struct CouplingRow {
  Vec3<Real> out;     ///< unit, W: a positive force pushes the first end this way
  Vec3<Real> arm[2];  ///< from the bodies' origins to the ends, W [m]
  Real gap;           ///< excess distance of the ends along `out` [m]
  Real rounding;      ///< gaps up to this value count as zero [m]
  Real rate;          ///< rate of the gap [m/s]
  Real bend;          ///< growth of `rate` due to the rotation of `out` [m/s^2]
};

template <class Real>
struct CouplingWorkspace {
  Real* bodies = nullptr;            ///< kBodyConstantCount per body
  Real* lengths = nullptr;           ///< per constraint [m]
  MaskOf<Real>* is_there = nullptr;  ///< per constraint
  MaskOf<Real>* is_held = nullptr;   ///< per constraint: whether its rows are active now
  MaskOf<Real>* was_held = nullptr;  ///< per constraint: active in the last constrain()
  MaskOf<Real>* is_taut = nullptr;   ///< per constraint: taut at the start of the step
  MaskOf<Real>* is_new = nullptr;    ///< per constraint: a rope that became taut within the step
  MaskOf<Real>* is_open = nullptr;   ///< per constraint: gap left open by the last project()
  Vec3<Real>* coupling_forces = nullptr;  ///< per constraint: force on the first end, W [N]
  MaskOf<Real>* held_before = nullptr;    ///< per constraint: was_held, as stored by remember()
  Vec3<Real>* forces_before = nullptr;    ///< per constraint: coupling_forces, likewise

  CouplingRow<Real>* rows = nullptr;
  Real* change = nullptr;             ///< per row, then per u: effect of a unit force on u
  CouplingEquations<Real> equations;  ///< forces or impulses of the rows, by changes of their rates

  Real* shift = nullptr;    ///< per u
  Real* nothing = nullptr;  ///< per u: zeros
  Real* driven = nullptr;   ///< 7 per driven base: its coordinates at the end of a step
  BodyKinematics<Real>* motion = nullptr;
  BodyKinematics<Real>* at_rest = nullptr;
  SpatialForce<Real>* forces = nullptr;
  BodyAccelerationOf<Real>* accelerations = nullptr;
  typename MultibodyTree::template Work<Real> multibody;

  /// @tparam Arena  has take(array, count)
  template <class Arena>
  SKYBODY_INLINE void take_from(Arena& arena, const CouplingScene& scene) {
    const std::size_t constraints = scene.constraints.size(), count = scene.row_owners.size();
    if (constraints == 0) return;
    const std::size_t body_count = scene.world.bodies.size();
    const auto us = static_cast<std::size_t>(scene.world.layout.u.size);
    arena.take(bodies, kBodyConstantCount * body_count);
    arena.take(lengths, constraints);
    arena.take(coupling_forces, constraints);
    arena.take(forces_before, constraints);
    arena.take(rows, count);
    arena.take(change, count * us);
    equations.take_from(arena, count);
    for (Real** values : {&shift, &nothing}) arena.take(*values, us);
    arena.take(driven, 7 * scene.driven.size());
    arena.take(motion, body_count);
    arena.take(at_rest, body_count);
    arena.take(forces, body_count);
    arena.take(accelerations, body_count);
    arena.take(multibody.body, body_count);
    arena.take(multibody.ball, body_count);
    arena.take(multibody.acceleration, body_count);
    for (MaskOf<Real>** masks :
         {&is_there, &is_held, &was_held, &is_taut, &is_new, &is_open, &held_before}) {
      arena.take(*masks, constraints);
    }
  }
};

}  // namespace skybody
