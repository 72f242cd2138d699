// Names and units of a controller's command, value by value.
#pragma once

#include <string>
#include <vector>

#include "core/env/environment.h"
#include "core/io/flight_log.h"

namespace skybody {

/// One column per value of the command that `controller` takes, named ROBOT.COMPONENT.
std::vector<LogColumn> command_columns(const Environment& environment,
                                       const PluginInstance& controller);

}  // namespace skybody
