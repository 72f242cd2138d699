// YAML -> Scenario. scenario_fields.h declares the contents of a file.
//
// Files named in a scenario (models, rotors, includes) are relative to the file that contains the
// name; names on the command line are relative to the working directory.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/plugin_catalog.h"
#include "core/model/scenario.h"

namespace skybody {

/// Changes a scenario's tree before it is read. Errors go to the diagnostics.
using ScenarioEdit = std::function<void(ConfigNode& root, Diagnostics& diagnostics)>;

/// Reads a scenario:
/// 1. reads `file` with its includes
/// 2. applies `overrides` (`PATH=VALUE` each, in order)
/// 3. applies `edit`, if given
/// 4. reads every model that the scenario names
/// Returns nullopt after errors; `diagnostics` then has all of them.
std::optional<Scenario> read_scenario(const std::string& file,
                                      const std::vector<std::string>& overrides,
                                      const PluginCatalog& catalog, Diagnostics& diagnostics,
                                      const ScenarioEdit& edit = {});

}  // namespace skybody
