// How far a ray goes until it meets an obstacle, in closed form. Solids are convex: a ray is in one
// over an interval, where it is within all slabs and rounds at once (Kay and Kajiya, "Ray tracing
// complex scenes", SIGGRAPH 1986).
#pragma once

#include "plugins/obstacles/placed.h"

namespace skybody::obstacles {

/// From `from` on along `along`, a unit vector.
template <class Real>
struct Ray {
  Vec3<Real> from;   ///< [m]
  Vec3<Real> along;  ///< unit vector
};

/// Where on a ray something lies: from `enter` to `leave` [m]; nowhere where they are in the wrong
/// order.
template <class Real>
struct Interval {
  Real enter, leave;

  SKYBODY_INLINE Interval operator&(const Interval& b) const {
    return {max(enter, b.enter), min(leave, b.leave)};
  }
  /// The first point that is not behind: 0 where the ray begins inside, infinity where it misses.
  SKYBODY_INLINE Real first() const {
    const auto hit = logical_and(enter <= leave, leave >= 0.0);
    return select(hit, max(enter, Real(0.0)), Real(kInfinity));
  }
};

/// Between two faces at -half and half of one axis.
template <class Real>
SKYBODY_INLINE Interval<Real> in_slab(const Real& from, const Real& along, const Real& half) {
  // A ray along the faces meets them far away, before or behind: never 0 / 0.
  const Real pace = select(abs(along) < 1e-18, Real(1e-18), along);
  const Real a = (-half - from) / pace, b = (half - from) / pace;
  return {min(a, b), max(a, b)};
}

/// Where a |t|^2 + 2 b t + c <= 0: within a sphere, or a cylinder without ends.
template <class Real>
SKYBODY_INLINE Interval<Real> in_round(const Real& a, const Real& b, const Real& c) {
  const auto moves = a > 1e-12;  // across a cylinder's axis; else within it always or never
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

/// Along z, `half` to either side.
template <class Real>
SKYBODY_INLINE Interval<Real> in_cylinder(const Ray<Real>& ray, const Real& radius,
                                          const Real& half) {
  const Vec3<Real>&o = ray.from, &d = ray.along;
  return in_round(d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y,
                  o.x * o.x + o.y * o.y - radius * radius) &
         in_slab(o.z, d.z, half);
}

/// Until all below z = 0.
template <class Real>
SKYBODY_INLINE Real until_plane(const Ray<Real>& ray) {
  const auto falls = ray.along.z < 0.0;
  const Real way = ray.from.z / select(falls, -ray.along.z, Real(1.0));
  return select(ray.from.z <= 0.0, Real(0.0), select(falls, way, Real(kInfinity)));
}

/// How far a ray of W goes until it meets an obstacle, whether that is there or not [m]; 0 in it,
/// infinity past it.
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
