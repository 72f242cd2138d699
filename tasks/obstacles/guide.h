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
    Vec3<Real> best = straight;
    Real most(-kInfinity);
    for (int i = 0; i <= 2 * kSide; ++i) {  // straight ahead, one step left, one step right, ...
      const int steps = i % 2 == 0 ? -(i / 2) : (i + 1) / 2;
      const SinCos<double> turn = sincos(kTurn * steps);
      const Vec3<Real> along{turn.cos * straight.x - turn.sin * straight.y,
                             turn.sin * straight.x + turn.cos * straight.y, Real(0.0)};
      Real kept(room);
      for (int k = 1; k <= kLooks; ++k) {
        const Real reach = min(Real(kStride * k), far);
        kept = min(kept, nearest_surface(env, obstacles, p + reach * along));
      }
      const Real worth = (kRoom / room) * kept + turn.cos + kKeep * dot(flight, along);
      const auto better = worth > most;
      best = select(better, along, best);
      most = select(better, worth, most);
    }
    return best;
  }
};

}  // namespace skybody::obstacles
