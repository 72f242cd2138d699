// The contact force between two bodies at one contact point. On double and packs.
//
//   normal    f = k x^1.5 (1 + d v), d = 1.5 c, never pulling: K. H. Hunt, F. R. E. Crossley,
//             "Coefficient of restitution interpreted as damping in vibroimpact", 1975
//   friction  a bristle of stiffness k_t and damping c_t that bends by s as the surfaces slide past
//             each other, and slips where its force would exceed Coulomb's mu f: P. A. Cundall,
//             O. D. L. Strack, "A discrete numerical model for granular assemblies", 1979
//
// x is the depth, v its rate of growth. Damping factors are limited to m' / h, with m' the contact
// point's share of the bodies' mass and h the step. The substeps of a step (contact_forces.h) are
// so short that the law does not exceed this limit, as long as there are enough substeps. Otherwise
// limited_force() applies.
#pragma once

#include "core/base/math/math.h"
#include "core/physics/contact/contact_scene.h"

namespace skybody {

/// State of one contact point.
template <class Real>
struct ContactKinematics {
  Real depth;           ///< x [m]
  Vec3<Real> normal;    ///< push direction on the body, unit
  Vec3<Real> velocity;  ///< of the body relative to the other at this point, mean of the step [m/s]
  Vec3<Real> slide;   ///< displacement of the body relative to the other in the step, including the
                      ///< normal part [m]
  Real step;          ///< h [s]
  Real most_damping;  ///< m' / h [N s/m]
};

/// @param elastic      k x^1.5 [N]
/// @param dissipation  c [s/m]
/// @returns f [N]
template <class Real>
SKYBODY_INLINE Real normal_force(const ContactKinematics<Real>& touch, const Real& elastic,
                                 const Real& dissipation) {
  const Real damping = min(1.5 * dissipation * elastic, touch.most_damping);
  return max(elastic - damping * dot(touch.normal, touch.velocity), Real(0.0));
}

/// Normal force for a step that is too long for the spring. At the velocity 1 / d the law has no
/// force; velocities approach it from below. Let s be the sum over a body's contacts of h k x^1.5 d
/// / m_n, with m_n the effective mass of each along its normal. All contacts together then change
/// the velocity by at most s / (1 + s) of the distance to 1 / d.
/// @param sum  s; the larger one of two bodies
template <class Real>
SKYBODY_INLINE Real limited_force(const ContactKinematics<Real>& touch, const Real& elastic,
                                  const Real& dissipation, const Real& sum) {
  const Real share = 1.0 - 1.5 * dissipation * dot(touch.normal, touch.velocity);
  return elastic * max(share, Real(0.0)) / (1.0 + sum);
}

/// The part of a vector orthogonal to a unit vector.
template <class Real>
SKYBODY_INLINE Vec3<Real> across(const Vec3<Real>& normal, const Vec3<Real>& v) {
  return v - normal * dot(normal, v);
}

/// Friction with a bristle: its spring and damper in parallel, in series with the slip. While it
/// slips, force and bristle follow mu f = k_t s + c_t ds/dt, so that it never bends further than
/// the surfaces slide.
/// @param most     mu f [N]
/// @param bristle  s of the previous step [m]; written: s after this step
template <class Real>
SKYBODY_INLINE Vec3<Real> bristle_force(const ContactKinematics<Real>& touch, const ContactLaw& law,
                                        const Real& most, Vec3<Real>& bristle) {
  const Real stiffness(law.bristle_stiffness);
  const Real damping = min(Real(law.bristle_damping), touch.most_damping);
  const Vec3<Real> before = across(touch.normal, bristle);
  const Vec3<Real> bent = before + across(touch.normal, touch.slide);
  const Vec3<Real> wanted = bent * stiffness + across(touch.normal, touch.velocity) * damping;
  const Real size = norm(wanted);
  const auto slips = size > most;
  const Real share = select(slips, most / select(slips, size, Real(1.0)), Real(1.0));
  const Vec3<Real> force = wanted * share;
  const Real resists = max(stiffness * touch.step + damping, Real(1e-300));
  const Vec3<Real> slipped = (force * touch.step + before * damping) * (1.0 / resists);
  bristle = select(slips, slipped, bent);
  return -force;
}

/// Friction without a bristle: stops sliding within a few steps, and creeps under a load.
/// @param velocity  across the normal
/// @param speed     its norm
/// @param damping   limited such that no step gains energy
/// @param most      mu f [N]
template <class Real>
SKYBODY_INLINE Vec3<Real> viscous_friction_force(const Vec3<Real>& velocity, const Real& speed,
                                                 const Real& damping, const Real& most) {
  const auto slips = damping * speed > most;
  return velocity * -select(slips, most / select(slips, speed, Real(1.0)), damping);
}

}  // namespace skybody
