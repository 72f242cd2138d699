// Names and units of a controller's command, value by value.
#pragma once

#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"
#include "core/io/files/flight_log.h"

namespace skybody {

/// One column per value of a chain's command, named ROBOT.COMPONENT.
std::vector<LogColumn> command_columns(const CompiledScenario& compiled,
                                       const ControllerChain& chain);

/// Names of the values of an action row: those of the commands, or the task's own.
std::vector<std::string> action_names(const CompiledScenario& compiled);

}  // namespace skybody
