// YAML -> Scenario. What a file may contain is declared in scenario_fields.h.
//
// Files named in a scenario (models, rotors, includes) are relative to the file in which the name
// is written; names on the command line are relative to the working directory.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/io/config_tree.h"
#include "core/io/plugin_catalog.h"
#include "core/model/scenario.h"

namespace skybody {

/// Changes a scenario's tree before it is read; errors go to the diagnostics.
using ScenarioEdit = std::function<void(ConfigNode& root, Diagnostics& diagnostics)>;

/// Reads `file` with its includes, applies `overrides` (`PATH=VALUE` each, in order), then
/// `edit` where there is one, and reads every model it names. Nothing if there are errors;
/// `diagnostics` then has all of them.
std::optional<Scenario> read_scenario(const std::string& file,
                                      const std::vector<std::string>& overrides,
                                      const PluginCatalog& catalog, Diagnostics& diagnostics,
                                      const ScenarioEdit& edit = {});

}  // namespace skybody
