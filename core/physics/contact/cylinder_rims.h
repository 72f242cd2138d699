// Contact of a cylinder's rim with a flat surface. On double and packs.
//
// A rim touches a plane at its lowest point. An upright cylinder has no unique lowest point, and
// for a slightly tilted one the neighbouring points are about as low: the cylinder needs several
// points to stand on. A rim therefore has eight fixed points and a ninth at its lowest point:
//
//   tilt = sine of the angle between axis and normal
//
//   tilt           ninth point                 eight points
//   below 0.01     moves out from the centre   at the rim
//   0.01 to 0.02   at the rim                  at the rim
//   0.02 to 0.05   at the rim                  move in to the centre
//   above          at the rim                  at the centre, without contact
//
// Positions are continuous functions of the attitude. The ninth point shares the bristle of the
// first of the eight points: above 0.05 only the ninth one touches. If both touch, the ninth is the
// second contact of that bristle.
#pragma once

#include <array>

#include "core/base/math/math.h"
#include "core/base/math/vec3.h"

namespace skybody {

/// Fixed points of a rim.
inline constexpr int kRimPoints = 8;

/// A rim at one instant, all in one frame.
template <class Real>
struct Rim {
  Vec3<Real> middle;  ///< [m]
  Vec3<Real> axis;    ///< unit
  Real radius;        ///< [m]
};

/// Vector from a rim's centre towards its lowest point with respect to a normal. Its length is the
/// sine of the angle between axis and normal.
/// @param out  unit: the normal
template <class Real>
SKYBODY_INLINE Vec3<Real> way_down(const Vec3<Real>& axis, const Vec3<Real>& out) {
  return axis * dot(axis, out) - out;
}

/// The ninth point. @param down  way_down() @param tilt  its length
template <class Real>
SKYBODY_INLINE Vec3<Real> lowest_place(const Rim<Real>& rim, const Vec3<Real>& down,
                                       const Real& tilt) {
  constexpr double kAtTheRim = 0.01;
  return rim.middle + down * (rim.radius / max(tilt, Real(kAtTheRim)));
}

/// Radial position of the eight points: 1 at the rim, 0 at its centre.
template <class Real>
SKYBODY_INLINE Real share_of_fixed(const Real& tilt) {
  constexpr double kUpright = 0.02, kLeaning = 0.05;
  return clamp((kLeaning - tilt) * (1.0 / (kLeaning - kUpright)), Real(0.0), Real(1.0));
}

/// Calls f(place, k) for the nine points; k is the one of the eight points that has the same
/// bristle.
/// @param spoke  spoke(k): the vector from the centre to fixed point k
template <class Real, class Spoke, class F>
SKYBODY_INLINE void each_rim_place(const Rim<Real>& rim, const Vec3<Real>& out, const Spoke& spoke,
                                   const F& f) {
  const Vec3<Real> down = way_down(rim.axis, out);
  const Real tilt = norm(down), share = share_of_fixed(tilt);
#pragma GCC unroll 1
  for (int k = 0; k <= kRimPoints; ++k) {  // one call of f, which may be long
    const bool is_fixed = k < kRimPoints;
    f(is_fixed ? rim.middle + spoke(k) * share : lowest_place(rim, down, tilt), is_fixed ? k : 0);
  }
}

/// A rim of a body, for contact with the ground.
struct GroundRim {
  Rim<double> rim;                              ///< in the body's frame
  std::array<Vec3<double>, kRimPoints> spokes;  ///< from its centre to its fixed points
  int bristle = 0;                              ///< of the first fixed point
};

/// Calls f(place, bristle) for all points of a rim, in W, that may touch the ground.
/// @param motion  of the body: position and axes
template <class Motion, class F>
SKYBODY_INLINE void each_ground_place(const GroundRim& rim, const Motion& motion, const F& f) {
  using Real = std::decay_t<decltype(motion.position.x)>;
  const Rim<Real> now{motion.position + motion.axes * to_real<Real>(rim.rim.middle),
                      motion.axes * to_real<Real>(rim.rim.axis), Real(rim.rim.radius)};
  const Vec3<Real> up{Real(0.0), Real(0.0), Real(1.0)};
  each_rim_place(
      now, up,
      [&](int k) SKYBODY_INLINE_LAMBDA {
        return motion.axes * to_real<Real>(rim.spokes[static_cast<std::size_t>(k)]);
      },
      [&](const Vec3<Real>& place, int k) SKYBODY_INLINE_LAMBDA { f(place, rim.bristle + k); });
}

/// Height of the lowest point of a rim above the body's origin, along W's z.
/// @param row  W's z in the body's frame
template <class Real>
SKYBODY_INLINE Real lowest_of_rim(const GroundRim& rim, const Vec3<Real>& row) {
  const Real upright = dot(row, to_real<Real>(rim.rim.axis));
  const Real tilt = sqrt(max(1.0 - upright * upright, Real(0.0)));
  return dot(row, to_real<Real>(rim.rim.middle)) - rim.rim.radius * tilt;
}

}  // namespace skybody
