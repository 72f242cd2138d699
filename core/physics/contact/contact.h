// Contacts of bodies, for output.
#pragma once

#include "core/base/math/vec3.h"

namespace skybody {

/// Values of Contact::other for partners other than bodies: the ground, and obstacle i as
/// kFirstObstacle - i.
inline constexpr int kGround = -1;
inline constexpr int kFirstObstacle = -2;

constexpr bool is_obstacle(int other) { return other <= kFirstObstacle; }
constexpr int obstacle_of(int other) { return kFirstObstacle - other; }

/// One contact of a body with the ground, an obstacle or another body.
struct Contact {
  int body = 0;                        ///< world body index
  int other = kGround;                 ///< world body index, kGround or an obstacle
  Vec3<double> point{0.0, 0.0, 0.0};   ///< point of action of the force, W [m]
  Vec3<double> normal{0.0, 0.0, 1.0};  ///< unit, W: push direction on `body`
  double depth = 0.0;                  ///< penetration, >= 0 [m]
  Vec3<double> force{0.0, 0.0, 0.0};   ///< on `body`, friction included, W axes [N]
};

}  // namespace skybody
