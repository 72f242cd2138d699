// The entries of a scenario that name plugins.
#pragma once

#include <string>
#include <vector>

#include "core/io/config_tree.h"
#include "core/io/diagnostics.h"
#include "core/io/plugin_catalog.h"
#include "core/model/scenario.h"

namespace skybody {

/// "; `ctbr` is a controller", for a name that stands for something else; empty where no plugin of
/// any kind has it.
std::string plugin_hint(const std::string& name, const PluginCatalog& catalog);

/// Reads one use of a plugin: `{plugin: NAME, name: INSTANCE, parameters: {...}}`. Parameters are
/// validated against the plugin's declaration; after errors they are what could be read.
PluginUse read_plugin_use(const ConfigNode& node, SkybodyKind kind, const PluginCatalog& catalog,
                          Diagnostics& diagnostics);

/// Reads a list of uses (null or absent: none). Instance names must differ.
std::vector<PluginUse> read_plugin_uses(const ConfigNode* node, SkybodyKind kind,
                                        const PluginCatalog& catalog, Diagnostics& diagnostics);

}  // namespace skybody
