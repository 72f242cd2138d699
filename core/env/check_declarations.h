// What a plugin declared in configure() is checked before anything relies on it.
#pragma once

#include "core/env/plugin_instance.h"
#include "core/physics/world/world.h"

namespace skybody {

/// @throws Error that names the plugin, the declaration and what is allowed
void check_declarations(const Topology& topology, const Layout& layout,
                        const PluginInstance& plugin);

}  // namespace skybody
