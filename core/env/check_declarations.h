// Checks of a plugin's declarations, made in configure(), before the engine uses them.
#pragma once

#include "core/env/plugin_instance.h"
#include "core/physics/world/world.h"

namespace skybody {

/// @throws Error with the plugin, the faulty declaration and the allowed values
void check_declarations(const Topology& topology, const StateLayout& layout,
                        const PluginInstance& plugin);

}  // namespace skybody
