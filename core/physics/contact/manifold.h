// The places where two shapes touch, found by a function of their own: for each width of packs
// there is one, which every kernel of contact calls (the code is long).
#pragma once

#include <type_traits>

#include "core/physics/contact/contact_scene.h"

namespace skybody {

/// One place where two shapes touch.
template <class Real>
struct ContactPoint {
  Vec3<Real> point;  ///< W [m]
  Vec3<Real> out;    ///< the way in which the first placed is pushed off, unit
  Real depth;        ///< [m]
  MaskOf<Real> touches;
  int bristle;  ///< -1: none
  int pair;     ///< whose place it is: of ContactWorkspace::near; set by who asked for it
};

/// Places where things touch, added to a list with room for them (ContactScene::most_places).
template <class Real>
struct Manifold {
  ContactPoint<Real>* places;
  int count = 0;

  SKYBODY_INLINE void add(const Vec3<Real>& point, const Vec3<Real>& out, const Real& depth,
                          int bristle, const MaskOf<Real>& touches) {
    if (none(touches)) return;  // most places of things that touch with the others
    places[count++] = {point, out, depth, touches, bristle, -1};
  }
};

/// If pairs are left to be looked at after so many places, every loop over the places of a part
/// finds them again.
inline constexpr int kKeptPlaces = 256;

/// What to find the places of.
template <class Real>
struct CollideCall {
  const ContactShape &model_a, &model_b;
  const PlacedShape<Real>&a, &b;
  const MaskOf<Real>& is_close;  ///< lanes to look at
  Manifold<Real>& out;
};

/// Adds the places where two shapes touch. @param call  a CollideCall of the width's type of number
using CollideFunction = void(const void* call);

/// @param lanes  1: of doubles; else of packs
CollideFunction* collide_function(int lanes);

template <class Real>
SKYBODY_INLINE void collide(const CollideCall<Real>& call) {
  collide_function(kLanesOf<Real>)(&call);
}

}  // namespace skybody
