// The physics steps of training: fewer and longer ones than those of the scenario.
#pragma once

#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"
#include "learn/hyperparameters.h"

namespace skybody::learn {

/// Physics steps per action.
struct PhysicsSteps {
  double dt;  ///< [s]
  int count;
};

/// Steps of the training version of a scenario: its own, or fewer of the same total duration.
PhysicsSteps training_steps(const CompiledScenario& compiled, const Hyperparameters& hyper);

/// Overrides ("PATH=VALUE", LoadOptions::overrides) that turn a scenario into its training version:
/// `physics_steps` physics steps per action, which are longer, so that the duration of an action is
/// unchanged. Times of observed sensors, which are numbers of physics steps, keep their seconds.
/// Empty: the scenario's own steps.
/// @throws Error if a sensor's time would be no whole number of physics steps
std::vector<std::string> training_overrides(const CompiledScenario& compiled,
                                            const Hyperparameters& hyper);

}  // namespace skybody::learn
