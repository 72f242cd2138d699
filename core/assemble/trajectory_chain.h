// Chains of shipped laws that take a trajectory, with its derivatives and what lies ahead.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody {

/// Parameters that let such a chain take the derivatives.
struct TrajectoryChain {
  bool position = false;  ///< `signal: trajectory` of `position`, the first controller
  bool attitude = false;  ///< `feed_forward: true` of `attitude`, the first or behind `position`

  bool any() const { return position || attitude; }
};

/// The first controller of a robot's chain, as the scenario has it.
const PluginUse& first_controller(const CompiledScenario& compiled, const ControllerChain& chain);

/// Which of these parameters the scenario leaves open.
/// @param chain  controllers of a robot, from the chain's first on
/// @param count  of the chain's controllers
TrajectoryChain open_trajectory_chain(const PluginUse* chain, int count);

/// From one point of a trajectory to the next, as the law takes them [s]; 0: it does not say.
double point_spacing(const PluginUse& law);

/// Whether the task says where its robot should be over time, with velocity and acceleration.
bool has_trajectory(const PluginUse& task);

/// Where the task has a trajectory, the chain of its robot takes it: `position` and `attitude` at
/// the head of the robot's controllers get the parameters that the scenario leaves open.
void take_trajectory_of_task(Scenario& scenario);

}  // namespace skybody
