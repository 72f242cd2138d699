// Observations of the obstacles nearest to a robot. Make it a member of a task, among its
// parameters.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <string>
#include <vector>

#include "plugins/task_kit/obstacles.h"
#include "plugins/task_kit/parts.h"

namespace skybody::task_kit {

/// Parts of one robot's observation, the nearest obstacle first.
struct ObstacleParts {
  std::vector<Part> offsets, distances;
};

/// The obstacles of a scenario, and the number that robots observe.
class NearestObstacles {
 public:
  explicit NearestObstacles(Plugin* owner) : owner_(owner) {}

  /// @throws std::runtime_error if Obstacles::configure() does
  void configure(const Setup& setup, const std::string& task) {
    obstacles_.configure(setup, task);
    seen_ = std::min(static_cast<int>(seen_parameter_.value()), obstacles_.count());
  }
  int count() const { return obstacles_.count(); }  ///< in the scenario
  int seen() const { return seen_; }

  /// Declares a robot's parts, `PREFIXobstacle_1.offset` and so on.
  ObstacleParts declare(const Setup& setup, ObservationParts& observation,
                        const std::string& prefix, int robot) const {
    const double sight = sight_.value();
    ObstacleParts parts;
    for (int k = 0; k < seen_; ++k) {
      const std::string of = prefix + "obstacle_" + std::to_string(k + 1) + ".";
      parts.offsets.push_back(observation.add(
          setup, {of + "offset", "m", 3,
                  "nearest point of an obstacle - position, W; shortened to `obstacle_sight`",
                  -sight, sight, robot}));
      parts.distances.push_back(observation.add(
          setup, {of + "distance", "m", 1, "length of the offset", 0.0, sight, robot}));
    }
    return parts;
  }

  /// Writes the observation from `point`.
  /// @returns the distance of the nearest obstacle [m], infinite if there is none
  template <class Real>
  SKYBODY_INLINE Real observe(const EnvView<Real>& env, const Vec3<Real>& point,
                              const ObstacleParts& parts, const Values<Real>& row) const {
    const auto sorted = obstacles_.nearest_of(env, point, std::max(seen_, 1));
    const Real sight(sight_.value());
    for (int k = 0; k < seen_; ++k) {
      const auto place = static_cast<std::size_t>(k);
      const Real& distance = sorted[place].distance;
      parts.offsets[place].set(row, sorted[place].offset * (sight / max(distance, sight)));
      parts.distances[place].set(row, min(distance, sight));
    }
    return sorted[0].distance;
  }

 private:
  Plugin* owner_;
  IntegerParameter seen_parameter_{
      owner_, integer("obstacles_seen", "", 3, between(0, Obstacles::kMostSeen),
                      "number of observed obstacles, the nearest ones; all if there are fewer")};
  RealParameter sight_{owner_, real("obstacle_sight", "m", 4.0, at_least(0.01),
                                    "longer vectors to obstacles are shortened to this length")};
  Obstacles obstacles_;
  int seen_ = 0;
};

}  // namespace skybody::task_kit
