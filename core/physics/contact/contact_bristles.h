// Bristles: the deformations of contact points that stick, in the environments of one Real. On
// double and packs.
#pragma once

#include "core/physics/contact/contact_workspace.h"

namespace skybody {

/// The bristles of all bodies with near pairs.
template <class Real>
struct ContactBristles {
  const ContactScene& scene;
  const ContactWorkspace<Real>& work;

  /// Ends the substep: stores the bristles of the last ContactForces::act(), in the lanes of a
  /// mask.
  SKYBODY_INLINE void bend(const MaskOf<Real>& is_active) const {
    const Vec3<Real> zero = SpatialForce<Real>::zero().force;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      // Bristles of a body without near pairs stay unchanged, whatever happens in other lanes.
      const auto here = logical_and(is_active, work.is_body_near[b]);
      if (none(here)) continue;
      for (int i = scene.bodies[b].first_bristle; i < scene.bodies[b].last_bristle; ++i) {
        if (work.is_idle[i]) continue;
        const Vec3<Real> bent = select(work.is_bent[i], work.bent[i], zero);
        work.bristles[i] = select(here, bent, work.bristles[i]);
      }
    }
  }

  /// Loads the bristles of all bodies with near pairs. @param load  load(i) fills bristle i
  template <class Load>
  SKYBODY_INLINE void take(const Load& load) const {
    each_near([&](int i) SKYBODY_INLINE_LAMBDA {
      load(i);
      const Vec3<Real>& b = work.bristles[i];
      const auto words = bit_cast_word(b.x) | bit_cast_word(b.y) | bit_cast_word(b.z);
      work.is_idle[i] = none(words != Word<Real>(0));
    });
  }

  /// Calls f(i) for those bristles that are not idle.
  template <class F>
  SKYBODY_INLINE void each_busy(const F& f) const {
    each_near([&](int i) SKYBODY_INLINE_LAMBDA {
      if (!work.is_idle[i]) f(i);
    });
  }

  /// Calls f(i) for the bristles of all bodies with near pairs.
  template <class F>
  SKYBODY_INLINE void each_near(const F& f) const {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      if (none(work.is_body_near[b])) continue;
      for (int i = scene.bodies[b].first_bristle; i < scene.bodies[b].last_bristle; ++i) f(i);
    }
  }
};

}  // namespace skybody
