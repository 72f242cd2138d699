// A collision shape at its pose at one instant. On double and packs.
#pragma once

#include "core/base/math/mat3.h"
#include "core/model/robot_model.h"
#include "core/physics/shapes/height_field.h"
#include "core/physics/shapes/surface_distance.h"

namespace skybody {

/// Rounding of a disabled shape: it is far from everything.
inline constexpr double kNoShape = -1e30;

/// The heights of a height field, for all environments.
struct FieldHeights {
  const HeightField* field = nullptr;
  double reach = 0.0;  ///< distances from the surface up to this one are exact: from the centre of
                       ///< any body's shape to its farthest point, plus a margin [m]
};

/// A box, cylinder, sphere or capsule about its centre, or a plane or height field with empty space
/// above it.
template <class Real>
struct PlacedShape {
  ShapeType type = ShapeType::kSphere;
  Vec3<Real> position;  ///< of its centre, W [m]
  Mat3<Real> axes;      ///< W from the shape's frame
  Vec3<Real> half;  ///< half its size along its axes. Sphere: 0. Capsule: z is half the distance
                    ///< between its caps. Plane and height field: z is the greatest height [m]
  Real rounding;    ///< points this near belong to the shape: the radius of a sphere or capsule,
                    ///< otherwise 0; kNoShape: disabled
  FieldHeights heights = {};  ///< of a height field

  /// @param at  in units of `half`
  SKYBODY_INLINE Vec3<Real> place(const Vec3<double>& at) const {
    return position + axes * Vec3<Real>{half.x * at.x, half.y * at.y, half.z * at.z};
  }
  SKYBODY_INLINE Vec3<Real> to_local(const Vec3<Real>& point) const {
    return transpose_times(axes, point - position);
  }
  /// Extent from its centre along a unit vector, W; an upper bound for a cylinder.
  SKYBODY_INLINE Real extent(const Vec3<Real>& along) const {
    const Vec3<Real> local = transpose_times(axes, along);
    return (abs(local.x) * half.x + abs(local.y) * half.y) + (abs(local.z) * half.z + rounding);
  }
  /// Distance of a point from the surface, and normal; both in the shape's frame.
  SKYBODY_INLINE SurfaceDistance<Real> distance(const Vec3<Real>& local) const {
    SurfaceDistance<Real> d;
    if (type == ShapeType::kBox) {
      d = box_distance(half, local);
    } else if (type == ShapeType::kCylinder) {
      d = cylinder_distance(half.x, half.z, local);
    } else if (type == ShapeType::kCapsule) {
      d = capsule_distance(Real(0.0), half.z, local);
    } else if (type == ShapeType::kPlane) {
      d = plane_distance(local);
    } else if (type == ShapeType::kHeightField) {
      d = distance_from_heights(*heights.field, half.x, half.y, heights.reach, local);
    } else {
      d = sphere_distance(Real(0.0), local);
    }
    d.distance = d.distance - rounding;
    return d;
  }
};

/// A quarter of a shape's least width: the limit of penetration [m].
template <class Real>
SKYBODY_INLINE Real penetration_limit(const Vec3<Real>& half, const Real& rounding) {
  return 0.5 * (min(half.x, min(half.y, half.z)) + rounding);
}

/// The deepest point of a line segment in a convex shape.
template <class Real>
struct EdgeDepth {
  Real distance;            ///< from the surface at this point [m]; negative: inside
  Vec3<Real> normal;        ///< the way out, orthogonal to the segment, unit, in the shape's frame
  Real share;               ///< fraction of the segment from its start
  MaskOf<Real> is_between;  ///< the deepest point is between the ends, not at one of them
};

/// The distance is convex along the segment, so its slope changes sign once. Bisects the segment,
/// then treats the distance as linear on both sides. If two faces meet at the point, the normal is
/// the weighted mean of their normals that is orthogonal to the segment: the normal of two crossing
/// edges.
/// @param start, end  in the shape's frame
template <class Real>
SKYBODY_INLINE EdgeDepth<Real> edge_depth(const PlacedShape<Real>& placed, const Vec3<Real>& start,
                                          const Vec3<Real>& end) {
  constexpr int kHalvings = 10;
  const Vec3<Real> along = end - start;
  Real low(0.0), high(1.0);
  SurfaceDistance<Real> below = placed.distance(start), above = placed.distance(end);
  Real falls = dot(below.normal, along), climbs = dot(above.normal, along);
  const auto is_between = logical_and(falls<0.0, climbs> 0.0);
  if (none(is_between)) return {Real(0.0), below.normal, low, is_between};
#pragma GCC unroll 1
  for (int i = 0; i < kHalvings; ++i) {
    const Real middle = 0.5 * (low + high);
    const SurfaceDistance<Real> d = placed.distance(start + along * middle);
    const Real slope = dot(d.normal, along);
    const auto is_falling = slope < 0.0;
    low = select(is_falling, middle, low);
    high = select(is_falling, high, middle);
    falls = select(is_falling, slope, falls);
    climbs = select(is_falling, climbs, slope);
    below.distance = select(is_falling, d.distance, below.distance);
    above.distance = select(is_falling, above.distance, d.distance);
    below.normal = select(is_falling, d.normal, below.normal);
    above.normal = select(is_falling, above.normal, d.normal);
  }
  const Real turn = select(is_between, climbs - falls, Real(1.0));
  const Real gap = high - low;
  const Real beyond = (above.distance - climbs * gap - below.distance) / -turn;
  const Real step = max(Real(0.0), min(beyond, gap));
  const Real weight = climbs / turn;
  const Vec3<Real> normal = below.normal * weight + above.normal * (1.0 - weight);
  const Real length = max(norm(normal), Real(0.1));
  return {(below.distance + falls * step) / length, normal * (1.0 / length), low + step,
          is_between};
}

}  // namespace skybody
