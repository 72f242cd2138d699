// Observation of the obstacles around a robot: the nearest ones, in order of distance.
#pragma once

#include <vector>

#include "plugins/obstacles/distance.h"
#include "plugins/obstacles/nearest.h"

namespace skybody::obstacles {

inline constexpr int kMostSeen = 12;

/// One observed obstacle. Beyond the view's range, way and size are 0.
template <class Real>
struct Seen {
  Real distance;    ///< of its surface; the view's range if there is none [m]
  Vec3<Real> way;   ///< vector to the nearest point of the surface, W [m]
  Vec3<Real> size;  ///< size as defined by its kind [m]
};

template <class Real>
SKYBODY_INLINE Seen<Real> choose(const MaskOf<Real>& mask, const Seen<Real>& a,
                                 const Seen<Real>& b) {
  using skybody::choose;
  return {choose(mask, a.distance, b.distance), choose(mask, a.way, b.way),
          choose(mask, a.size, b.size)};
}

/// All observed obstacles, and the distance of the nearest one, observed or not.
template <class Real>
struct Sight {
  Seen<Real> seen[kMostSeen];  ///< the nearest first; at equal distance in the scenario's order
  Real nearest;                ///< distance of the nearest surface [m]; infinity if there is none
};

/// Observes the surroundings of `p`.
/// @param count  number of observed obstacles, at most kMostSeen
/// @param view  range [m]
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

}  // namespace skybody::obstacles
