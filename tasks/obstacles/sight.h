// What a robot sees of the obstacles around it: the nearest ones, in order.
#pragma once

#include <vector>

#include "plugins/obstacles/distance.h"
#include "plugins/obstacles/nearest.h"

namespace skybody::obstacles {

inline constexpr int kMostSeen = 12;

/// One obstacle as it is seen. What is farther than the view is not: the way and the size are 0.
template <class Real>
struct Seen {
  Real distance;    ///< of its surface; the view where nothing is [m]
  Vec3<Real> way;   ///< to the nearest point of the surface, W [m]
  Vec3<Real> size;  ///< as its kind says [m]
};

template <class Real>
SKYBODY_INLINE Seen<Real> choose(const MaskOf<Real>& mask, const Seen<Real>& a,
                                 const Seen<Real>& b) {
  using skybody::choose;
  return {choose(mask, a.distance, b.distance), choose(mask, a.way, b.way),
          choose(mask, a.size, b.size)};
}

/// All that is seen, and how near the nearest obstacle is, seen or not.
template <class Real>
struct Sight {
  Seen<Real> seen[kMostSeen];  ///< the nearest first; obstacles as near as one another in the
                               ///< scenario's order
  Real nearest;                ///< distance of its surface [m]; infinity where nothing is
};

/// Looks around from `p`.
/// @param count  how many are seen, kMostSeen at most; @param view  how far [m]
template <class Real>
SKYBODY_INLINE Sight<Real> look(const EnvView<Real>& env, const std::vector<Obstacle>& obstacles,
                                const Vec3<Real>& p, int count, double view) {
  const Vec3<Real> nothing{Real(0.0), Real(0.0), Real(0.0)};
  Sight<Real> sight;
  sight.nearest = Real(kInfinity);
  for (int k = 0; k < count; ++k) sight.seen[k] = {Real(view), nothing, nothing};
  for (const Obstacle& obstacle : obstacles) {
    const PlacedObstacle<Real> placed = place(env, obstacle);
    const Gap<Real> to = gap(obstacle, placed, p);
    const Real distance = select(placed.present, to.distance, Real(kInfinity));
    sight.nearest = min(sight.nearest, distance);
    put_in_order(Seen<Real>{distance, to.way, placed.size}, sight.seen, count);
  }
  return sight;
}

/// How near the nearest surface is to `p` [m]; infinity where nothing is.
template <class Real>
SKYBODY_INLINE Real nearest_surface(const EnvView<Real>& env,
                                    const std::vector<Obstacle>& obstacles, const Vec3<Real>& p) {
  Real nearest(kInfinity);
  for (const Obstacle& obstacle : obstacles) {
    const PlacedObstacle<Real> placed = place(env, obstacle);
    nearest =
        min(nearest, select(placed.present, gap(obstacle, placed, p).distance, Real(kInfinity)));
  }
  return nearest;
}

}  // namespace skybody::obstacles
