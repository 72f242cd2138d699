// Who draws which EnvParam: one plugin each, and where it is read.
#pragma once

#include <vector>

#include "core/env/initial_states.h"
#include "core/env/plugin_instance.h"

namespace skybody {

/// What writes EnvParams in a scenario.
struct Writers {
  const std::vector<PluginInstance>& randomizers;
  const PluginInstance& task;
  Block task_params;  ///< the task's own, within the parameter block
  const InitialStates& starts;
  const Layout& layout;
  const Scenario& scenario;
};

/// @throws LocatedError that names the parameter, who draws it and the remedy, where two draw one,
///         a task draws another's, or a start is drawn in mid-episode
void check_writers(const Writers& writers);

}  // namespace skybody
