// One environment's physical values, contiguous: the state that a reset starts from.
#pragma once

#include <vector>

#include "core/base/quat.h"
#include "core/base/vec3.h"

namespace skybody {

/// Position and motion of one body frame. 13 doubles in this order everywhere (plugins included).
struct BodyState {
  Vec3<double> position{0.0, 0.0, 0.0};          ///< origin in W [m]
  Quat<double> rotation{1.0, 0.0, 0.0, 0.0};     ///< W from B
  Vec3<double> velocity{0.0, 0.0, 0.0};          ///< of the origin, W axes [m/s]
  Vec3<double> angular_velocity{0.0, 0.0, 0.0};  ///< B axes [rad/s]
};
static_assert(sizeof(BodyState) == 13 * sizeof(double));

/// Values of one lane gathered from WorldState, in the order of the layout's blocks.
struct LaneState {
  std::vector<double> q, u, rotor_speed, rotor_command, wrench, drive, params;
  std::vector<BodyState> bodies;  ///< those of q and u
};

}  // namespace skybody
