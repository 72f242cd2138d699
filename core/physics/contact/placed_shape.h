// A placed that bodies touch with, where it is at one instant. On double and packs.
#pragma once

#include "core/base/mat3.h"
#include "core/model/robot_model.h"
#include "core/physics/shapes/height_field.h"
#include "core/physics/shapes/surface_distance.h"

namespace skybody {

/// Rounding of a placed that is switched off: everything is far from it.
inline constexpr double kNoShape = -1e30;

/// The heights of a height field, for all environments.
struct FieldHeights {
  const HeightField* field = nullptr;
  double reach = 0.0;  ///< how far from the surface distances are exact: the way from the centre of
                       ///< any body's placed to its farthest point [m]
};

/// A box, cylinder, sphere or capsule about its centre, or a plane or height field above which
/// there is nothing.
template <class Real>
struct PlacedShape {
  ShapeType type = ShapeType::kSphere;
  Vec3<Real> position;  ///< of its centre, W [m]
  Mat3<Real> axes;      ///< W from the placed's frame
  Vec3<Real> half;      ///< half its size along its axes; of a sphere 0, of a capsule half the way
                        ///< between its caps along z; of a plane and a height field z is the
                        ///< greatest height [m]
  Real rounding;  ///< what is so near belongs to it: the radius of a sphere or capsule, else 0;
                  ///< or kNoShape
  FieldHeights heights = {};  ///< of a height field

  /// @param at  in units of `half`
  SKYBODY_INLINE Vec3<Real> place(const Vec3<double>& at) const {
    return position + axes * Vec3<Real>{half.x * at.x, half.y * at.y, half.z * at.z};
  }
  SKYBODY_INLINE Vec3<Real> to_local(const Vec3<Real>& point) const {
    return transpose_times(axes, point - position);
  }
  /// How far it reaches from its centre along a unit vector, W; of a cylinder no less than that.
  SKYBODY_INLINE Real extent(const Vec3<Real>& along) const {
    const Vec3<Real> local = transpose_times(axes, along);
    return (abs(local.x) * half.x + abs(local.y) * half.y) + (abs(local.z) * half.z + rounding);
  }
  /// From its surface, of a point in its frame; the normal is in its frame, too.
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

/// A quarter of a placed's least width: how deep anything may get into it, or it into anything [m].
template <class Real>
SKYBODY_INLINE Real penetration_limit(const Vec3<Real>& half, const Real& rounding) {
  return 0.5 * (min(half.x, min(half.y, half.z)) + rounding);
}

/// Where a straight line is deepest in a convex placed.
template <class Real>
struct EdgeDepth {
  Real distance;      ///< from the surface there [m]; negative: inside
  Vec3<Real> normal;  ///< the way out at right angles to the line, unit, in the placed's frame
  Real share;         ///< of the way from the line's start to its end
  MaskOf<Real> is_between;  ///< it is deepest between its ends, and not at one of them
};

/// The distance is convex along the line, so that its slope changes sign once: bisected, and at
/// last taken as linear on both sides. Where two faces meet in the point the way out is that mean
/// of their normals which is at right angles to the line: the normal of the crossing of two edges.
/// @param start, end  in the placed's frame
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
