// The JSON schema of scenario files, for completion and checks in editors.
#pragma once

#include <string>

#include "core/io/yaml/plugin_catalog.h"

namespace skybody {

/// JSON Schema (draft-07) from the declared keys and the declarations of all plugins: descriptions
/// with units, defaults, ranges, and an enumeration of plugin names, each with its parameters.
std::string scenario_schema(const PluginCatalog& catalog);

}  // namespace skybody
