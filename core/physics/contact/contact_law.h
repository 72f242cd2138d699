// The force between two things at one place where they touch. On double and packs.
//
//   normal    f = k x^1.5 (1 + d v), d = 1.5 c, never pulling: K. H. Hunt, F. R. E. Crossley,
//             "Coefficient of restitution interpreted as damping in vibroimpact", 1975
//   friction  a bristle of stiffness k_t and damping c_t that bends by s as the places slide past
//             each other, and slips where it would carry more than Coulomb's mu f: P. A. Cundall,
//             O. D. L. Strack, "A discrete numerical model for granular assemblies", 1979
//
// x is the depth, v the rate at which it grows. What multiplies a velocity is at most m' / h, m'
// the share of the bodies' mass that the place feels and h the step: parts of a step
// (contact_step.h) are so short that no more is asked for, as long as there are enough of them.
// Where there are not, limited_force() holds.
#pragma once

#include "core/base/math.h"
#include "core/physics/contact/contact_scene.h"

namespace skybody {

/// What touches at one place.
template <class Real>
struct ContactKinematics {
  Real depth;           ///< x [m]
  Vec3<Real> normal;    ///< the way in which the body is pushed off, unit
  Vec3<Real> velocity;  ///< of the body's place past the other's, mean of the step [m/s]
  Vec3<Real> slide;   ///< how far it has gone past it since the step before, along the normal, too
                      ///< [m]
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

/// The same for a step that is too long for the spring. Velocities approach 1 / d, at which the law
/// has no force, from below: with s the sum over a body's contacts of h k x^1.5 d / m_n, m_n the
/// mass that each meets along its normal, all of them together take no more than s / (1 + s) of the
/// way.
/// @param sum  s; of two bodies the larger one
template <class Real>
SKYBODY_INLINE Real limited_force(const ContactKinematics<Real>& touch, const Real& elastic,
                                  const Real& dissipation, const Real& sum) {
  const Real share = 1.0 - 1.5 * dissipation * dot(touch.normal, touch.velocity);
  return elastic * max(share, Real(0.0)) / (1.0 + sum);
}

/// Of a vector, what lies at right angles to a unit vector.
template <class Real>
SKYBODY_INLINE Vec3<Real> across(const Vec3<Real>& normal, const Vec3<Real>& v) {
  return v - normal * dot(normal, v);
}

/// Friction with a bristle: its spring and damper lie in line with what slips. While it slips,
/// force and bristle follow mu f = k_t s + c_t ds/dt, so that it never bends further than the
/// places slide.
/// @param most     mu f [N]
/// @param bristle  s of the step before [m]; written: where it is after this one
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

/// Friction where no bristle is kept: it stops what slides within a few steps, and lets it creep
/// under a load.
/// @param velocity  across the normal
/// @param speed     its norm
/// @param damping   such that no step gains energy by it
/// @param most      mu f [N]
template <class Real>
SKYBODY_INLINE Vec3<Real> viscous_friction_force(const Vec3<Real>& velocity, const Real& speed,
                                                 const Real& damping, const Real& most) {
  const auto slips = damping * speed > most;
  return velocity * -select(slips, most / select(slips, speed, Real(1.0)), damping);
}

}  // namespace skybody
