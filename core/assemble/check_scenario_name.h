// Checks the name of a scenario on the command line or in Python.
#pragma once

#include <string>

#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Reports a scenario that does not exist, with a similar name, and files that are something else
/// than a scenario, with their use.
/// @param scenario  YAML file, or the name of a shipped scenario
/// @returns whether there is such a file, which may be a scenario
bool check_scenario_name(const std::string& scenario, Diagnostics& diagnostics);

}  // namespace skybody
