// Chains of shipped controllers with a trajectory as input: its derivatives and future points.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody {

/// The parameters with which such a chain uses the derivatives.
struct TrajectoryChain {
  bool position = false;  ///< `signal: trajectory` of `position`, the first controller
  bool attitude = false;  ///< `feed_forward: true` of `attitude`, the first or after `position`

  bool any() const { return position || attitude; }
};

/// The first controller of a robot's chain in the scenario.
const PluginUse& first_controller(const CompiledScenario& compiled, const ControllerChain& chain);

/// The parameters of TrajectoryChain that the scenario does not set.
/// @param chain  the robot's controllers, from the chain's first on
/// @param count  number of the chain's controllers
TrajectoryChain open_trajectory_chain(const PluginUse* chain, int count);

/// The time between two trajectory points in the controller's input [s]; 0: not specified.
double point_spacing(const PluginUse& law);

/// Whether the task defines its robot's desired position over time, with velocity and acceleration.
bool has_trajectory(const PluginUse& task);

/// If the task has a trajectory, makes it the input of its robot's chain: sets the parameters of
/// `position` and `attitude`, the robot's first controllers, that the scenario does not set.
void take_trajectory_of_task(Scenario& scenario);

}  // namespace skybody
