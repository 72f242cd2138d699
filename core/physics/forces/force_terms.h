// The terms of the forces on one body, except weight and rotors. Every term adds to an
// OriginForceAccumulator or a FreeBodyForceAccumulator (force_accumulators.h). On double and packs.
#pragma once

#include "core/physics/forces/force_accumulators.h"
#include "core/physics/world/lane_values.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Adds a force at the centre of mass, W axes, and a moment. Sums of lanes in which both are zero
/// stay unchanged.
template <class Real, class Load>
SKYBODY_INLINE void add_at_com_where_any(const Vec3<Real>& force, const Vec3<Real>& moment,
                                         Axes moment_axes, Load& load) {
  const auto any = logical_or(is_not_zero(force), is_not_zero(moment));
  if (none(any)) return;
  load.add_where(any, [&](Load& sum) SKYBODY_INLINE_LAMBDA {
    sum.add_at_com(force, Axes::kWorld);
    sum.add_moment(moment, moment_axes);
  });
}

/// Disturbance of paper eq. 1: F_W at the base's centre of mass in W axes, M_B in base axes.
/// @param disturbance  the robot's kRobotParamCount values: a pointer, or a view
template <class Real, class Params, class Load>
SKYBODY_INLINE void add_disturbance(const Params& disturbance, Load& load) {
  add_at_com_where_any(load_vec3(disturbance + kDisturbanceForce),
                       load_vec3(disturbance + kDisturbanceMoment), Axes::kBody, load);
}

/// A controller's wrench.
/// @param wrench  force, then moment: a pointer to six values, or a view
template <class Real, class Values, class Load>
SKYBODY_INLINE void add_wrench(const WrenchSite& site, const Values& wrench, Load& load) {
  const Axes axes = site.world_axes ? Axes::kWorld : Axes::kBody;
  const Vec3<Real> force = load_vec3(wrench);
  load.add_moment(load_vec3(wrench + 3), axes);
  if (site.at_com) {
    load.add_at_com(force, axes);
  } else {
    load.add_at_point(to_real<Real>(site.point), force, axes);
  }
}

/// Velocity of a body's origin through the air, body axes.
/// @param held  null: no effects
/// @param index of the body
template <class Real>
SKYBODY_INLINE Vec3<Real> air_velocity(const HeldLanes<Real>* held, int index,
                                       const BodyKinematics<Real>& body) {
  Vec3<Real> velocity = body.velocity;
  if (held != nullptr && held->has(SKYBODY_HELD_WIND)) {
    velocity = velocity - load_vec3((*held)[SKYBODY_HELD_WIND] + 3 * index);
  }
  return transpose_times(body.axes, velocity);
}

/// Aerodynamic drag of a body, at its centre of mass: along each body axis
///   F = -(linear + quadratic |v|) v, v the velocity of the centre of mass through the air.
/// @param drag  three linear coefficients, then three quadratic ones: a pointer, or a view
template <class Real, class Values, class Load>
SKYBODY_INLINE void add_body_drag(const Values& drag, const Vec3<Real>& air_velocity,
                                  const BodyKinematics<Real>& body, Load& load) {
  const Vec3<Real> linear = load_vec3(drag), quadratic = load_vec3(drag + 3);
  const auto is_quadratic = is_not_zero(quadratic);
  const auto any = logical_or(is_not_zero(linear), is_quadratic);
  const Vec3<Real> v = air_velocity + cross(body.spin, load.com());
  Vec3<Real> factor = linear;
  if (!none(is_quadratic)) factor += quadratic * norm(v);
  const Vec3<Real> force{-(factor.x * v.x), -(factor.y * v.y), -(factor.z * v.z)};
  load.add_where(any, [&](Load& sum) SKYBODY_INLINE_LAMBDA { sum.add_drag(force); });
}

/// A body's held wrench (SKYBODY_HELD_WRENCH).
template <class Real, class Load>
SKYBODY_INLINE void add_held_wrench(const HeldLanes<Real>& held, int index, Load& load) {
  const LaneValues<Real> wrench = held[SKYBODY_HELD_WRENCH] + 6 * index;
  add_at_com_where_any(load_vec3(wrench), load_vec3(wrench + 3), Axes::kWorld, load);
}

/// The forces of held inputs on one body: wrench and drag.
template <class Real, class Load>
SKYBODY_INLINE void add_held_forces(const HeldLanes<Real>& held, int index,
                                    const BodyKinematics<Real>& body, Load& load) {
  if (held.has(SKYBODY_HELD_WRENCH)) add_held_wrench(held, index, load);
  if (held.has(SKYBODY_HELD_BODY_DRAG)) {
    add_body_drag<Real>(held[SKYBODY_HELD_BODY_DRAG] + 6 * index, air_velocity(&held, index, body),
                        body, load);
  }
}

}  // namespace skybody
