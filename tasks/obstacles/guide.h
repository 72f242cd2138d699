// Local planner of a baseline without obstacle avoidance: selects, of headings near the target's,
// the one with the most clearance. This is the choice of the vector field histogram (J. Borenstein
// and Y. Koren, "The vector field histogram - fast obstacle avoidance for mobile robots", IEEE
// Transactions on Robotics and Automation 7(3), 1991), with distances to surfaces in place of a
// grid.
#pragma once

#include <vector>

#include "tasks/obstacles/sight.h"

namespace skybody::obstacles {

struct Guide {
  static constexpr int kSide = 7;         // headings on either side of the target's
  static constexpr double kTurn = 0.21;   // angle between two of them [rad]
  static constexpr int kLooks = 7;        // positions sampled along each heading
  static constexpr double kStride = 0.3;  // distance between these [m]
  static constexpr double kRoom = 3.0;    // weight of full clearance, relative to cos(turn)
  static constexpr double kKeep = 0.3;    // weight of the present direction of flight

  /// A unit vector in the plane: the direction from `p` towards `target`.
  /// @param velocity  of the flight [m/s]
  /// @param room  clearance beyond this has no further value
  template <class Real>
  static Vec3<Real> way(const EnvView<Real>& env, const std::vector<Obstacle>& obstacles,
                        const Vec3<Real>& p, const Vec3<Real>& target, const Vec3<Real>& velocity,
                        double room) {
    const Vec3<Real> level{target.x - p.x, target.y - p.y, Real(0.0)};
    const Real far = norm(level);
    const Vec3<Real> straight = select(far > 1e-9, level / max(far, Real(1e-9)),
                                       Vec3<Real>{Real(1.0), Real(0.0), Real(0.0)});
    const Vec3<Real> flight = velocity / max(norm(velocity), Real(1.0));
    Vec3<Real> along[kHeadings];  // straight ahead, one step left, one step right, ...
    Real kept[kHeadings];
    double ahead[kHeadings];
    for (int i = 0; i < kHeadings; ++i) {
      const int steps = i % 2 == 0 ? -(i / 2) : (i + 1) / 2;
      const SinCos<double> turn = sincos(kTurn * steps);
      along[i] = {turn.cos * straight.x - turn.sin * straight.y,
                  turn.sin * straight.x + turn.cos * straight.y, Real(0.0)};
      ahead[i] = turn.cos;
      kept[i] = room;
    }
    for (const Obstacle& obstacle : obstacles) keep(env, obstacle, p, far, room, along, kept);
    Vec3<Real> best = straight;
    Real most(-kInfinity);
    for (int i = 0; i < kHeadings; ++i) {
      const Real worth = (kRoom / room) * kept[i] + ahead[i] + kKeep * dot(flight, along[i]);
      const auto better = worth > most;
      best = select(better, along[i], best);
      most = select(better, worth, most);
    }
    return best;
  }

 private:
  static constexpr int kHeadings = 2 * kSide + 1;

  /// Lowers the clearances `kept` of the headings `along` to those from an obstacle.
  /// @param far  the target's distance: no position beyond it counts [m]
  template <class Real>
  static void keep(const EnvView<Real>& env, const Obstacle& obstacle, const Vec3<Real>& p,
                   const Real& far, double room, const Vec3<Real>* along, Real* kept) {
    constexpr double kMargin = 1e-3;  // of rounding [m]
    const PlacedObstacle<Real> placed = place(env, obstacle);
    const auto distance = [&](const Vec3<Real>& from) {
      return select(placed.present, gap(obstacle, placed, from).distance, Real(kInfinity));
    };
    // Distances change by no more than the way: most obstacles are too far to matter.
    if (none(distance(p) < kLooks * kStride + room + kMargin)) return;
    for (int i = 0; i < kHeadings; ++i) {
      for (int k = 1; k <= kLooks; ++k) {
        const Real reach = min(Real(kStride * k), far);
        kept[i] = min(kept[i], distance(p + reach * along[i]));
      }
    }
  }
};

}  // namespace skybody::obstacles
