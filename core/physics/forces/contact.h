// Where bodies touch something, for looking at: forces act through ForceModel and Simbody.
#pragma once

#include <vector>

#include "core/base/vec3.h"
#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// What a body touches where that is no body of the world.
inline constexpr int kGround = -1;
inline constexpr int kObstacle = -2;

/// One place where a body touches the ground, an obstacle or another body.
struct Contact {
  int body = 0;                        ///< world body index
  int other = kGround;                 ///< kGround, kObstacle, or world body index
  Vec3<double> point{0.0, 0.0, 0.0};   ///< where the force acts, W [m]
  Vec3<double> normal{0.0, 0.0, 1.0};  ///< unit, W: the way in which `body` is pushed off
  double depth = 0.0;                  ///< penetration, >= 0 [m]
  Vec3<double> force{0.0, 0.0, 0.0};   ///< on `body`, friction included, W axes [N]
};

/// The contact spheres that are in the ground, with the forces of ground_contact.h.
/// @param params  the world's kWorldParamCount values
std::vector<Contact> ground_contacts(const World& world, const double* params,
                                     const std::vector<BodyState>& bodies);

}  // namespace skybody
