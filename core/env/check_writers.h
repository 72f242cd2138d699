// Checks that each EnvParam is drawn by at most one plugin, and at a time when it is still read.
#pragma once

#include <vector>

#include "core/env/initial_states.h"
#include "core/env/plugin_instance.h"

namespace skybody {

/// The plugins of a scenario that write EnvParams.
struct Writers {
  const std::vector<PluginInstance>& randomizers;
  const PluginInstance& task;
  Block task_params;  ///< the task's own EnvParams, within the parameter block
  const InitialStates& starts;
  const StateLayout& layout;
  const Scenario& scenario;
};

/// @throws LocatedError with the parameter, its writers and the remedy if two plugins draw one
///   parameter, the task draws a parameter that is not its own, or a start is drawn during an
///   episode
void check_writers(const Writers& writers);

}  // namespace skybody
