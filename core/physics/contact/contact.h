// Where bodies touch something, for looking at.
#pragma once

#include "core/base/vec3.h"

namespace skybody {

/// What a body touches where that is no body of the world: the ground, or obstacle i as
/// kFirstObstacle - i.
inline constexpr int kGround = -1;
inline constexpr int kFirstObstacle = -2;

constexpr bool is_obstacle(int other) { return other <= kFirstObstacle; }
constexpr int obstacle_of(int other) { return kFirstObstacle - other; }

/// One place where a body touches the ground, an obstacle or another body.
struct Contact {
  int body = 0;                        ///< world body index
  int other = kGround;                 ///< world body index, kGround or an obstacle
  Vec3<double> point{0.0, 0.0, 0.0};   ///< where the force acts, W [m]
  Vec3<double> normal{0.0, 0.0, 1.0};  ///< unit, W: the way in which `body` is pushed off
  double depth = 0.0;                  ///< penetration, >= 0 [m]
  Vec3<double> force{0.0, 0.0, 0.0};   ///< on `body`, friction included, W axes [N]
};

}  // namespace skybody
