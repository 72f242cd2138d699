// Forces on bodies, summed about each body's origin.
#pragma once

#include "core/base/math/vec3.h"

namespace skybody {

/// A force and a moment on one body about the origin of its frame, both in W axes.
template <class Real>
struct SpatialForce {
  Vec3<Real> moment;  ///< [N m]
  Vec3<Real> force;   ///< [N]

  static SKYBODY_INLINE SpatialForce zero() {
    const Vec3<Real> none{Real(0.0), Real(0.0), Real(0.0)};
    return {none, none};
  }
  /// Adds a force [N] that acts at `arm` from the body's origin [m], W axes.
  SKYBODY_INLINE void add_force_at(const Vec3<Real>& arm, const Vec3<Real>& force_w) {
    force += force_w;
    moment += cross(arm, force_w);
  }
};

/// a where the mask is set, else b.
template <class Real>
SKYBODY_INLINE SpatialForce<Real> select(const MaskOf<Real>& mask, const SpatialForce<Real>& a,
                                         const SpatialForce<Real>& b) {
  return {select(mask, a.moment, b.moment), select(mask, a.force, b.force)};
}

}  // namespace skybody
