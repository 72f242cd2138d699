// Contact manifold: the contact points of two shapes. The code is long, so each width of packs has
// one function that all contact kernels share.
#pragma once

#include <type_traits>

#include "core/physics/contact/contact_scene.h"

namespace skybody {

/// One contact point of two shapes.
template <class Real>
struct ContactPoint {
  Vec3<Real> point;  ///< W [m]
  Vec3<Real> out;    ///< push direction on the first shape, unit
  Real depth;        ///< [m]
  MaskOf<Real> touches;
  int bristle;  ///< -1: none
  int pair;     ///< index of its pair in ContactWorkspace::near; set by the caller
};

/// A list of contact points with sufficient room (ContactScene::most_places).
template <class Real>
struct Manifold {
  ContactPoint<Real>* places;
  int count = 0;

  SKYBODY_INLINE void add(const Vec3<Real>& point, const Vec3<Real>& out, const Real& depth,
                          int bristle, const MaskOf<Real>& touches) {
    if (none(touches)) return;  // most points of touching shapes do not touch
    places[count++] = {point, out, depth, touches, bristle, -1};
  }
};

/// Number of contact points after which no further pairs are added. If pairs are left, every loop
/// over the contact points of a substep computes them again.
inline constexpr int kKeptPlaces = 256;

/// Arguments of a collision query.
template <class Real>
struct CollideCall {
  const ContactShape &model_a, &model_b;
  const PlacedShape<Real>&a, &b;
  const MaskOf<Real>& is_close;  ///< lanes to test
  Manifold<Real>& out;
};

/// Adds the contact points of two shapes. @param call  a CollideCall with the number type of the
/// width
using CollideFunction = void(const void* call);

/// @param lanes  1: doubles; otherwise packs
CollideFunction* collide_function(int lanes);

template <class Real>
SKYBODY_INLINE void collide(const CollideCall<Real>& call) {
  collide_function(kLanesOf<Real>)(&call);
}

}  // namespace skybody
