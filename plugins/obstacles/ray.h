// Distance along a ray to an obstacle, in closed form. The shapes are convex: a ray is inside over
// an interval, the intersection of the intervals of all slabs and round surfaces (Kay and Kajiya,
// "Ray tracing complex scenes", SIGGRAPH 1986).
#pragma once

#include "plugins/obstacles/placed.h"

namespace skybody::obstacles {

/// A half-line from `from` in the direction `along`.
template <class Real>
struct Ray {
  Vec3<Real> from;   ///< [m]
  Vec3<Real> along;  ///< unit vector
};

/// A stretch of a ray from `enter` to `leave` [m]; empty if enter > leave.
template <class Real>
struct Interval {
  Real enter, leave;

  SKYBODY_INLINE Interval operator&(const Interval& b) const {
    return {max(enter, b.enter), min(leave, b.leave)};
  }
  /// Distance to the first point at or ahead of the ray's origin: 0 if the ray starts inside,
  /// infinity if it misses.
  SKYBODY_INLINE Real first() const {
    const auto hit = logical_and(enter <= leave, leave >= 0.0);
    return select(hit, max(enter, Real(0.0)), Real(kInfinity));
  }
};

/// Between two faces at -half and half on one axis.
template <class Real>
SKYBODY_INLINE Interval<Real> in_slab(const Real& from, const Real& along, const Real& half) {
  // A ray parallel to the faces meets them far away, ahead or behind: avoids 0 / 0.
  const Real pace = select(abs(along) < 1e-18, Real(1e-18), along);
  const Real a = (-half - from) / pace, b = (half - from) / pace;
  return {min(a, b), max(a, b)};
}

/// Where a |t|^2 + 2 b t + c <= 0: inside a sphere, or an infinite cylinder.
template <class Real>
SKYBODY_INLINE Interval<Real> in_round(const Real& a, const Real& b, const Real& c) {
  const auto moves = a > 1e-12;  // moves across a cylinder's axis; otherwise always or never inside
  const Real square = b * b - a * c;
  const Real root = sqrt(max(square, Real(0.0))), divisor = select(moves, a, Real(1.0));
  const auto hit = select(moves, square, -c) >= 0.0;
  const Real far(kInfinity);
  const Interval<Real> whole{select(moves, (-b - root) / divisor, -far),
                             select(moves, (root - b) / divisor, far)};
  return {select(hit, whole.enter, far), select(hit, whole.leave, -far)};
}

template <class Real>
SKYBODY_INLINE Interval<Real> in_sphere(const Ray<Real>& ray, const Real& radius) {
  return in_round(Real(1.0), dot(ray.from, ray.along), squared_norm(ray.from) - radius * radius);
}

template <class Real>
SKYBODY_INLINE Interval<Real> in_box(const Ray<Real>& ray, const Vec3<Real>& half) {
  return in_slab(ray.from.x, ray.along.x, half.x) & in_slab(ray.from.y, ray.along.y, half.y) &
         in_slab(ray.from.z, ray.along.z, half.z);
}

/// Cylinder along z, `half` to either side.
template <class Real>
SKYBODY_INLINE Interval<Real> in_cylinder(const Ray<Real>& ray, const Real& radius,
                                          const Real& half) {
  const Vec3<Real>&o = ray.from, &d = ray.along;
  return in_round(d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y,
                  o.x * o.x + o.y * o.y - radius * radius) &
         in_slab(o.z, d.z, half);
}

/// Distance to the half-space below z = 0.
template <class Real>
SKYBODY_INLINE Real until_plane(const Ray<Real>& ray) {
  const auto falls = ray.along.z < 0.0;
  const Real way = ray.from.z / select(falls, -ray.along.z, Real(1.0));
  return select(ray.from.z <= 0.0, Real(0.0), select(falls, way, Real(kInfinity)));
}

/// Distance from the origin of a ray in W to an obstacle, present or not [m]; 0 inside it, infinity
/// if the ray misses.
template <class Real>
SKYBODY_INLINE Real until(const Obstacle& obstacle, const PlacedObstacle<Real>& placed,
                          const Ray<Real>& ray) {
  const Ray<Real> local{placed.local(ray.from), rotate_inverse(placed.rotation, ray.along)};
  const Vec3<Real>& size = placed.size;
  const Real half = 0.5 * size.y;
  switch (obstacle.kind) {
    case SKYBODY_BOX:
      return in_box(local, 0.5 * size).first();
    case SKYBODY_CYLINDER:
      return in_cylinder(local, size.x, half).first();
    case SKYBODY_CAPSULE: {
      const Vec3<Real> cap{Real(0.0), Real(0.0), half};
      const Ray<Real> to_top{local.from - cap, local.along}, to_foot{local.from + cap, local.along};
      return min(in_cylinder(local, size.x, half).first(),
                 min(in_sphere(to_top, size.x).first(), in_sphere(to_foot, size.x).first()));
    }
    case SKYBODY_GATE: {
      Real nearest(kInfinity);
      for (int k = 0; k < kBars; ++k) {
        const Bar<Real> bar = bar_of_gate(size, k);
        const Ray<Real> to_bar{local.from - bar.position, local.along};
        nearest = min(nearest, in_box(to_bar, bar.half).first());
      }
      return nearest;
    }
    case SKYBODY_PLANE:
      return until_plane(local);
    default:
      return in_sphere(local, size.x).first();
  }
}

}  // namespace skybody::obstacles
