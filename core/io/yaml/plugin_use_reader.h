// Reads the uses of plugins in a scenario.
#pragma once

#include <string>
#include <vector>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/io/yaml/plugin_catalog.h"
#include "core/model/scenario.h"

namespace skybody {

/// "; `ctbr` is a controller", for a name of a plugin of another kind; empty if no plugin has the
/// name.
std::string plugin_hint(const std::string& name, const PluginCatalog& catalog);

/// Reads one use of a plugin: `{plugin: NAME, name: INSTANCE, parameters: {...}}`. Validates the
/// parameters against the plugin's declaration; after errors only the valid ones are meaningful.
PluginUse read_plugin_use(const ConfigNode& node, SkybodyKind kind, const PluginCatalog& catalog,
                          Diagnostics& diagnostics);

/// Reads a list of uses (null or absent: none). Instance names must differ.
std::vector<PluginUse> read_plugin_uses(const ConfigNode* node, SkybodyKind kind,
                                        const PluginCatalog& catalog, Diagnostics& diagnostics);

}  // namespace skybody
