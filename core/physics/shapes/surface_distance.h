// Distance of a point from the surface of a solid, in closed form. On double and packs. Points and
// normals are in the solid's frame.
#pragma once

#include "core/base/math/math.h"
#include "core/base/math/vec3.h"

namespace skybody {

template <class Real>
struct SurfaceDistance {
  Real distance;      ///< to the nearest point of the surface [m]; negative: inside
  Vec3<Real> normal;  ///< its gradient, unit: points the shortest way out
};

/// Distance from an edge of two faces: the greater of the distances beyond the faces, or the
/// distance from the edge if the point is beyond both.
/// @param x, y        distance beyond the faces [m]; negative: within
/// @param along_x, along_y  outward normals of the faces: unit, orthogonal
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> corner_distance(const Real& x, const Real& y,
                                                     const Vec3<Real>& along_x,
                                                     const Vec3<Real>& along_y) {
  const auto x_is_nearer = x > y;
  SurfaceDistance<Real> flat{select(x_is_nearer, x, y), select(x_is_nearer, along_x, along_y)};
  const auto is_beyond_both = logical_and(x > 0.0, y > 0.0);
  if (none(is_beyond_both)) return flat;
  const Real edge = sqrt(x * x + y * y);
  const Real safe = select(is_beyond_both, edge, Real(1.0));
  return {select(is_beyond_both, edge, flat.distance),
          select(is_beyond_both, (along_x * x + along_y * y) * (1.0 / safe), flat.normal)};
}

/// A sphere about the origin; at its centre the normal is z.
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> sphere_distance(const Real& radius, const Vec3<Real>& p) {
  const Real length = norm(p);
  const auto is_centre = length == 0.0;
  const Vec3<Real> up{Real(0.0), Real(0.0), Real(1.0)};
  return {length - radius, select(is_centre, up, p * (1.0 / select(is_centre, Real(1.0), length)))};
}

/// A box about the origin, along the axes.
/// @param half  half its edges [m]
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> box_distance(const Vec3<Real>& half, const Vec3<Real>& p) {
  const Real zero(0.0), one(1.0);
  const Vec3<Real> x_way{copysign(one, p.x), zero, zero}, y_way{zero, copysign(one, p.y), zero},
      z_way{zero, zero, copysign(one, p.z)};
  const SurfaceDistance<Real> side =
      corner_distance<Real>(abs(p.x) - half.x, abs(p.y) - half.y, x_way, y_way);
  return corner_distance<Real>(side.distance, abs(p.z) - half.z, side.normal, z_way);
}

/// A cylinder about the z axis; on the axis the normal of its side is x.
/// @param half  half its length [m]
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> cylinder_distance(const Real& radius, const Real& half,
                                                       const Vec3<Real>& p) {
  const Real zero(0.0), one(1.0);
  const Real off_axis = sqrt(p.x * p.x + p.y * p.y);
  const auto is_on_axis = off_axis == 0.0;
  const Real safe = select(is_on_axis, one, off_axis);
  const Vec3<Real> side_way{select(is_on_axis, one, p.x / safe), p.y / safe, zero};
  return corner_distance<Real>(off_axis - radius, abs(p.z) - half, side_way,
                               {zero, zero, copysign(one, p.z)});
}

/// A capsule about the z axis: all points within `radius` of a line segment. On the segment the
/// normal is x.
/// @param half  half the segment's length [m]
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> capsule_distance(const Real& radius, const Real& half,
                                                      const Vec3<Real>& p) {
  const Vec3<Real> apart{p.x, p.y, p.z - clamp(p.z, -half, half)};
  const Real length = norm(apart);
  const auto is_on_line = length == 0.0;
  const Vec3<Real> side{Real(1.0), Real(0.0), Real(0.0)};
  const Real safe = select(is_on_line, Real(1.0), length);
  return {length - radius, select(is_on_line, side, apart * (1.0 / safe))};
}

/// The half-space below z = 0.
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> plane_distance(const Vec3<Real>& p) {
  return {p.z, {Real(0.0), Real(0.0), Real(1.0)}};
}

}  // namespace skybody
