// A sphere on the plane z = 0 of W.
//   normal    f = k x^1.5 + d dx/dt with d = 1.5 c k x^1.5, never pulling. K. H. Hunt, F. R. E.
//             Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", 1975.
//   friction  -mu f v_t / sqrt(|v_t|^2 + v_s^2): Coulomb's, made smooth within v_s around rest
// What multiplies a velocity in them is at most m/dt, m being the nominal mass that the sphere
// carries and at most a quarter of its body's: beyond it, a time step that begins in a hard impact
// would turn the velocity round and gain energy. Integrators that control their error need no such
// bound and have none.
// x is the penetration of the lowest point; both forces act at that point.
#pragma once

#include "core/base/math.h"
#include "core/base/vec3.h"
#include "core/model/constants.h"

namespace skybody {

/// @param constants  the world's kWorldParamCount values, of which kDissipation c, kFriction mu and
///                   kSlipVelocity v_s count: a pointer, or a view
/// @param point, velocity  the sphere's lowest point [m] and its velocity [m/s], W
/// @param stiffness k [N/m^1.5]  @param most_damping m/dt [N s/m]
/// @returns the force on the body [N], W axes
template <class Real, class Params>
SKYBODY_INLINE Vec3<Real> ground_force(const Params& constants, const Vec3<Real>& point,
                                       const Vec3<Real>& velocity, double stiffness,
                                       double most_damping) {
  const Real zero(0.0);
  const Real dissipation = constants[kDissipation], friction = constants[kFriction];
  const Real slip_velocity = constants[kSlipVelocity];
  const Real penetration = select(point.z < zero, -point.z, zero);
  const Real elastic = stiffness * pow_3_2(penetration);
  const Real damping = min(1.5 * dissipation * elastic, Real(most_damping));
  const Real pushing = elastic - damping * velocity.z;
  const Real normal = select(pushing > zero, pushing, zero);
  const Real slip =
      sqrt((velocity.x * velocity.x + velocity.y * velocity.y) + slip_velocity * slip_velocity);
  const Real rubbing = min(friction * normal / slip, Real(most_damping));
  return {-(rubbing * velocity.x), -(rubbing * velocity.y), normal};
}

}  // namespace skybody
