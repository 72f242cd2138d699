// Distance and direction to an obstacle's surface, in closed form. gap() is signed: negative
// inside. way_to() is 0 inside. distance_to_gate() is a fast version for gates only.
#pragma once

#include "plugins/obstacles/placed.h"

namespace skybody::obstacles {

/// From a point to the nearest point of a surface.
template <class Real>
struct Gap {
  Real distance;   ///< below 0 inside [m]
  Vec3<Real> way;  ///< to that point [m]
};

template <class Real>
SKYBODY_INLINE Gap<Real> nearer(const Gap<Real>& a, const Gap<Real>& b) {
  const auto first = a.distance <= b.distance;
  return {select(first, a.distance, b.distance), select(first, a.way, b.way)};
}

/// From `p` to a sphere about the origin. At its centre the direction is up.
template <class Real>
SKYBODY_INLINE Gap<Real> gap_to_sphere(const Vec3<Real>& p, const Real& radius) {
  const Real square = squared_norm(p);
  const auto apart = square > 1e-24;
  const Real far = sqrt(select(apart, square, Real(1.0)));
  const Real distance = select(apart, far, Real(0.0)) - radius;
  const Vec3<Real> outward = select(apart, p / far, Vec3<Real>{Real(0.0), Real(0.0), Real(1.0)});
  return {distance, -distance * outward};
}

/// To a capsule along z: `half` is half the length between the centres of its caps.
template <class Real>
SKYBODY_INLINE Gap<Real> gap_to_capsule(const Vec3<Real>& p, const Real& radius, const Real& half) {
  const Real along = max(min(p.z, half), -half);
  return gap_to_sphere(Vec3<Real>{p.x, p.y, p.z - along}, radius);
}

/// To a box about the origin.
template <class Real>
SKYBODY_INLINE Gap<Real> gap_to_box(const Vec3<Real>& p, const Vec3<Real>& half) {
  const Vec3<Real> d{abs(p.x) - half.x, abs(p.y) - half.y, abs(p.z) - half.z};
  const Real most = max(max(d.x, d.y), d.z);
  const auto outside = most > 0.0;
  const Real zero(0.0);
  // Outside, all axes beyond their faces count. Inside, the nearest face counts.
  const auto by_x = d.x >= most;
  const auto by_y = logical_and(d.y >= most, logical_not(by_x));
  const auto by_z = logical_not(logical_or(by_x, by_y));
  const Vec3<Real> out{choose(outside, max(d.x, zero), choose(by_x, d.x, zero)),
                       choose(outside, max(d.y, zero), choose(by_y, d.y, zero)),
                       choose(outside, max(d.z, zero), choose(by_z, d.z, zero))};
  const Real square = select(outside, squared_norm(out), Real(1.0));
  return {select(outside, sqrt(square), most),
          {-copysign(Real(1.0), p.x) * out.x, -copysign(Real(1.0), p.y) * out.y,
           -copysign(Real(1.0), p.z) * out.z}};
}

/// To a cylinder along z: a box in the plane of its axis and `p`.
template <class Real>
SKYBODY_INLINE Gap<Real> gap_to_cylinder(const Vec3<Real>& p, const Real& radius,
                                         const Real& half) {
  const Real square = p.x * p.x + p.y * p.y;
  const auto apart = square > 1e-24;
  const Real aside = sqrt(select(apart, square, Real(1.0)));
  const Real zero(0.0);
  const Vec3<Real> outward{select(apart, p.x / aside, Real(1.0)), select(apart, p.y / aside, zero),
                           zero};
  const Gap<Real> flat = gap_to_box(Vec3<Real>{select(apart, aside, zero), zero, p.z},
                                    Vec3<Real>{radius, Real(kInfinity), half});
  return {flat.distance, {flat.way.x * outward.x, flat.way.x * outward.y, flat.way.z}};
}

/// From `p` to an obstacle, present or not; `p` and the result in W.
template <class Real>
SKYBODY_INLINE Gap<Real> gap(const Obstacle& obstacle, const PlacedObstacle<Real>& placed,
                             const Vec3<Real>& p) {
  const Vec3<Real> local = placed.local(p);
  const Vec3<Real>& size = placed.size;
  Gap<Real> found;
  switch (obstacle.kind) {
    case SKYBODY_BOX:
      found = gap_to_box(local, 0.5 * size);
      break;
    case SKYBODY_CYLINDER:
      found = gap_to_cylinder(local, size.x, 0.5 * size.y);
      break;
    case SKYBODY_CAPSULE:
      found = gap_to_capsule(local, size.x, 0.5 * size.y);
      break;
    case SKYBODY_GATE:
      for (int k = 0; k < kBars; ++k) {
        const Bar<Real> bar = bar_of_gate(size, k);
        const Gap<Real> to_bar = gap_to_box(local - bar.position, bar.half);
        found = k == 0 ? to_bar : nearer(found, to_bar);
      }
      break;
    case SKYBODY_PLANE:
      found = {local.z, {Real(0.0), Real(0.0), -local.z}};
      break;
    default:
      found = gap_to_sphere(local, size.x);
  }
  return {found.distance, rotate(placed.rotation, found.way)};
}

template <class Real>
SKYBODY_INLINE Real held_within(const Real& x, const Real& most) {
  return max(min(x, most), -most);
}
/// The factor that shortens a length to `most`; 1 if it is shorter.
template <class Real>
SKYBODY_INLINE Real share_within(const Real& length, const Real& most) {
  return most / max(length, most);
}

/// The point nearest to `p` of a box, a cylinder, a sphere or a capsule about the origin; `p`
/// itself if inside. Smooth in size and position, unlike gap(), which has to choose a face.
template <class Real>
SKYBODY_INLINE Vec3<Real> nearest_point(int kind, const Vec3<Real>& size, const Vec3<Real>& p) {
  switch (kind) {
    case SKYBODY_BOX:
      return {held_within(p.x, 0.5 * size.x), held_within(p.y, 0.5 * size.y),
              held_within(p.z, 0.5 * size.z)};
    case SKYBODY_CYLINDER: {
      const Real share = share_within(sqrt(p.x * p.x + p.y * p.y), size.x);
      return {p.x * share, p.y * share, held_within(p.z, 0.5 * size.y)};
    }
    case SKYBODY_SPHERE:
      return p * share_within(norm(p), size.x);
    default: {  // a capsule: a sphere about the nearest point of its axis
      const Vec3<Real> centre{Real(0.0), Real(0.0), held_within(p.z, 0.5 * size.y)};
      const Vec3<Real> aside = p - centre;
      return centre + aside * share_within(norm(aside), size.x);
    }
  }
}

/// From `p` to the nearest point of an obstacle, present or not; 0 inside. In W.
template <class Real>
SKYBODY_INLINE Vec3<Real> way_to(const Obstacle& obstacle, const PlacedObstacle<Real>& placed,
                                 const Vec3<Real>& p) {
  if (obstacle.kind == SKYBODY_GATE || obstacle.kind == SKYBODY_PLANE) {
    const Gap<Real> to = gap(obstacle, placed, p);
    return select(to.distance > 0.0, to.way, Vec3<Real>{Real(0.0), Real(0.0), Real(0.0)});
  }
  const Vec3<Real> local = placed.local(p);
  return rotate(placed.rotation, nearest_point(obstacle.kind, placed.size, local) - local);
}

/// Distance from `p`, a point in a gate's frame, to the nearest bar [m]; 0 inside a bar. Uses the
/// gate's symmetry, where gap() computes the distance bar by bar.
template <class Real>
SKYBODY_INLINE Real distance_to_gate(const Vec3<Real>& size, const Vec3<Real>& p) {
  const Real& bar = size.z;
  const Real y = abs(p.y) - 0.5 * size.x, z = abs(p.z) - 0.5 * size.y;  // from the opening's edge
  const Real depth = max(abs(p.x) - 0.5 * bar, Real(0.0));
  const Real beyond_y = max(y - bar, Real(0.0)), beyond_z = max(z - bar, Real(0.0));
  const Real inner = max(y, z);  // below 0 in the opening: minus the distance to the nearest bar
  const Real across = select(inner < 0.0, inner * inner, beyond_y * beyond_y + beyond_z * beyond_z);
  return sqrt(depth * depth + across);
}

}  // namespace skybody::obstacles
