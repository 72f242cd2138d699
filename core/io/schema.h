// The JSON schema of scenario files, so that editors complete and check them.
#pragma once

#include <string>

#include "core/io/plugin_catalog.h"

namespace skybody {

/// JSON Schema (draft-07) from the declared keys and the declarations of all plugins: descriptions
/// with units, defaults, ranges, plugin names as an enumeration with each plugin's own parameters.
std::string scenario_schema(const PluginCatalog& catalog);

}  // namespace skybody
