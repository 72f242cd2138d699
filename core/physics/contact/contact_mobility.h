// Responses of bodies to impulses at contact points, in the environments of one Real. On double and
// packs.
#pragma once

#include "core/physics/bodies/body_constants.h"
#include "core/physics/contact/contact_workspace.h"

namespace skybody {

/// Bodies respond as if they were free; those with a driven base do not respond.
template <class Real>
struct ContactMobility {
  using Motion = BodyKinematics<Real>;

  const Real* bodies;  ///< kBodyConstantCount values per body

  /// Inverse mass, 0 of a driven body [1/kg].
  SKYBODY_INLINE Real inverse_mass(const ContactBody& body) const {
    if (body.is_driven) return Real(0.0);
    return (bodies + kBodyConstantCount * body.body)[kBodyInverseMass];
  }

  /// Velocity change of a body by an impulse at a point.
  SKYBODY_INLINE BodyVelocityChange<Real> response(const ContactBody& body, const Motion* motion,
                                                   const Vec3<Real>& point,
                                                   const Vec3<Real>& impulse) const {
    const Motion& m = motion[body.body];
    const Real* c = bodies + kBodyConstantCount * body.body;
    const Vec3<Real> arm = point - m.position - m.axes * load_vec3(c + kBodyCom);
    const Vec3<Real> twist = transpose_times(m.axes, cross(arm, impulse));
    return {impulse * inverse_mass(body),
            m.axes * (load_sym_mat3(c + kBodyInverseInertia) * twist)};
  }
  /// Velocity change of a point from a velocity change of its body.
  SKYBODY_INLINE Vec3<Real> moved(const ContactBody& body, const Motion* motion,
                                  const Vec3<Real>& point,
                                  const BodyVelocityChange<Real>& change) const {
    const Motion& m = motion[body.body];
    const Vec3<Real> com = m.axes * load_vec3(bodies + (kBodyConstantCount * body.body + kBodyCom));
    return change.velocity + cross(change.angular_velocity, point - m.position - com);
  }

  /// Mobility of a point: its velocity change along a unit vector by a unit impulse along it
  /// [1/kg].
  SKYBODY_INLINE Real gives_at(const ContactBody& body, const Motion* motion,
                               const Vec3<Real>& point, const Vec3<Real>& along) const {
    if (body.is_driven) return Real(0.0);
    return dot(along, moved(body, motion, point, response(body, motion, point, along)));
  }
};

}  // namespace skybody
