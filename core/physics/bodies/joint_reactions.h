// Forces of joints on their bodies: Newton-Euler equations from the leaves to the bases, for given
// motion and forces (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, table 5.1). For sensors
// and tasks; the step does not need them. On double and packs.
#pragma once

#include "core/physics/bodies/body_accelerations.h"
#include "core/physics/bodies/body_constants.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/world/world.h"

namespace skybody {

namespace detail {

/// The force on a body that causes given accelerations: the rates of its momentum and of its
/// angular momentum about its origin, W axes.
/// @param constants  the body's parameters
template <class Real, class Values>
SKYBODY_INLINE SpatialForce<Real> momentum_rate(const Values& constants,
                                                const BodyKinematics<Real>& body,
                                                const BodyAccelerationOf<Real>& a) {
  const Vec3<Real> w = body.spin, com = load_vec3(constants + kCom);
  const Vec3<Real> com_in_body = cross(a.angular, com) + cross(w, cross(w, com));
  const Vec3<Real> force = (a.linear + body.axes * com_in_body) * Real(constants[kMass]);
  const SymMat3<Real> inertia = load_sym_mat3(constants + kInertia);
  const Vec3<Real> about_com = inertia * a.angular + cross(w, inertia * w);
  return {body.axes * about_com + cross(body.axes * com, force), force};
}

}  // namespace detail

/// Force and moment of each body's inboard joint on the body, about its origin, W axes [N, N m]:
/// the sum of constraint, spring, damper, limit and drive. For a base: the force that holds or
/// drives it; 0 up to round-off if it moves freely.
/// @param params         the parameter block: a pointer, or a view
/// @param motion, accelerations, loads  per body; loads: all forces except those of joints, W axes
///                       about the body's origin
/// @param out            per body, overwritten
template <class Real, class Values>
SKYBODY_INLINE void joint_reactions_of(const World& world, const Values& params,
                                       const BodyKinematics<Real>* motion,
                                       const BodyAccelerationOf<Real>* accelerations,
                                       const SpatialForce<Real>* loads, SpatialForce<Real>* out) {
  const auto bodies = static_cast<int>(world.bodies.size());
  for (int i = 0; i < bodies; ++i) {
    const auto constants = params + world.layout.body_params[static_cast<std::size_t>(i)];
    out[i] = detail::momentum_rate(constants, motion[i], accelerations[i]);
    out[i].force -= loads[i].force;
    out[i].moment -= loads[i].moment;
  }
  for (int i = bodies - 1; i >= 0; --i) {  // parents come before their children
    const int parent = world.bodies[static_cast<std::size_t>(i)].parent;
    if (parent < 0) continue;
    out[parent].moment += out[i].moment;
    out[parent].add_force_at(motion[i].position - motion[parent].position, out[i].force);
  }
}

/// Of one environment.
void joint_reactions(const World& world, const double* params, const BodyKinematics<double>* motion,
                     const BodyAcceleration* accelerations, const SpatialForce<double>* loads,
                     SpatialForce<double>* out);

}  // namespace skybody
