// A sphere on the plane z = 0 of W.
//   normal    f = k x^1.5 (1 + 1.5 c dx/dt), never pulling. K. H. Hunt, F. R. E. Crossley,
//             "Coefficient of restitution interpreted as damping in vibroimpact", 1975
//   friction  -mu f v_t / sqrt(|v_t|^2 + v_s^2): Coulomb's, made smooth within v_s around rest
// x is the penetration of the lowest point; both forces act at that point.
#pragma once

#include "core/base/math.h"
#include "core/base/vec3.h"

namespace skybody {

/// @param point, velocity  the sphere's lowest point [m] and its velocity [m/s], W
/// @param stiffness k [N/m^1.5]  @param dissipation c [s/m]  @param friction mu
/// @param slip_velocity v_s [m/s], > 0
/// @returns the force on the body [N], W axes
template <class Real>
SKYBODY_INLINE Vec3<Real> ground_force(const Vec3<Real>& point, const Vec3<Real>& velocity,
                                       const Real& stiffness, double dissipation, double friction,
                                       double slip_velocity) {
  const Real zero(0.0);
  const Real penetration = select(point.z < zero, -point.z, zero);
  const Real damping = 1.0 - (1.5 * dissipation) * velocity.z;
  const Real elastic = stiffness * pow_3_2(penetration);
  const Real normal = elastic * select(damping > zero, damping, zero);
  const Real slip =
      sqrt((velocity.x * velocity.x + velocity.y * velocity.y) + slip_velocity * slip_velocity);
  const Real drag = friction * normal / slip;
  return {-(drag * velocity.x), -(drag * velocity.y), normal};
}

}  // namespace skybody
