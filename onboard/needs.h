// The sources on which an observation depends, found by trial.
#pragma once

#include <string>
#include <vector>

#include "onboard/mission.h"

namespace skybody::onboard {

/// Sources of an observation beside the pose and twist of the vehicle's base.
struct Needs {
  std::vector<int> bodies;           ///< other bodies whose pose must be given
  bool imu = false;                  ///< whether a sensor with channels of an IMU is observed
  std::vector<std::string> unknown;  ///< columns that need something that no packet gives
  std::vector<std::vector<int>> bodies_of;  ///< of each column: bodies, without the base
};

/// Evaluates the task with other values of each source and compares the rows.
/// @throws Error as TaskHost
Needs find_needs(const Mission& mission);

}  // namespace skybody::onboard
