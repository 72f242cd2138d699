// Offsets from a robot to the nearest points of the nearest obstacles.
#pragma once

#include <skybody/plugin.h>

#include <array>
#include <string>
#include <vector>

#include "plugins/obstacles/distance.h"
#include "plugins/obstacles/nearest.h"

namespace skybody::task_kit {

/// The offset to an obstacle.
template <class Real>
struct ObstacleSight {
  Vec3<Real> offset;  ///< nearest point of the obstacle - point, W [m]; 0 if the point is inside
  Real distance;      ///< its length [m]; infinite: there is no such obstacle
};

template <class Real>
SKYBODY_INLINE ObstacleSight<Real> choose(const MaskOf<Real>& mask, const ObstacleSight<Real>& a,
                                          const ObstacleSight<Real>& b) {
  return {select(mask, a.offset, b.offset), select(mask, a.distance, b.distance)};
}

/// All obstacles of a scenario. Make it a member of a task.
class Obstacles {
 public:
  static constexpr int kMostSeen = 8;
  template <class Real>
  using Nearest = std::array<ObstacleSight<Real>, kMostSeen>;

  /// Finds the scenario's obstacles.
  /// @param task  its name, for the message
  /// @throws std::runtime_error if the surface of one has no closed form
  void configure(const Setup& setup, const std::string& task) {
    obstacles_ = obstacles::find(setup, "task `" + task + "`");
  }
  int count() const { return static_cast<int>(obstacles_.size()); }

  /// The offset to the nearest point of obstacle i. The distance is infinite if the environment
  /// does not have it.
  template <class Real>
  SKYBODY_INLINE ObstacleSight<Real> sight(const EnvView<Real>& env, int i,
                                           const Vec3<Real>& point) const {
    const obstacles::Obstacle& obstacle = obstacles_[static_cast<std::size_t>(i)];
    const obstacles::PlacedObstacle<Real> placed = obstacles::place(env, obstacle);
    const Vec3<Real> way = obstacles::way_to(obstacle, placed, point);
    return {select(placed.present, way, Vec3<Real>{Real(0.0), Real(0.0), Real(0.0)}),
            select(placed.present, norm(way), Real(kInfinity))};
  }

  /// The `seen` <= kMostSeen nearest obstacles, the nearest first; missing ones have offset 0 and
  /// infinite distance.
  template <class Real>
  SKYBODY_INLINE Nearest<Real> nearest_of(const EnvView<Real>& env, const Vec3<Real>& point,
                                          int seen) const {
    Nearest<Real> sorted;
    sorted.fill({{Real(0.0), Real(0.0), Real(0.0)}, Real(kInfinity)});
    for (int i = 0; i < count(); ++i) {
      obstacles::put_in_order(sight(env, i, point), sorted.data(), seen);
    }
    return sorted;
  }

 private:
  std::vector<obstacles::Obstacle> obstacles_;
};

}  // namespace skybody::task_kit
