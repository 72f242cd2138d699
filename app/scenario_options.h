// The arguments that name a scenario, shared by the commands that load one.
#pragma once

#include <memory>

#include "core/assemble/load.h"

namespace CLI {
class App;
}

namespace skybody {

/// Declares SCENARIO, --set, --plugin-path and --trust-scenario.
void add_scenario_options(CLI::App& command, LoadOptions& options);
/// Declares --plugin-path alone.
void add_plugin_path(CLI::App& command, LoadOptions& options);

/// Declares --trust-scenario alone.
void add_trust_scenario(CLI::App& command, LoadOptions& options);

/// Declares --reference.
void add_reference(CLI::App& command, LoadOptions& options);

/// Declares --checked.
void add_checked(CLI::App& command, LoadOptions& options);

/// All plugins that are found, opened. @throws InputError where a folder is not there
std::shared_ptr<PluginRegistry> open_plugins(const LoadOptions& options);

/// Loads it and prints its warnings.
/// @throws InputError with errors and warnings
std::shared_ptr<const CompiledScenario> load_and_warn(const LoadOptions& options);

}  // namespace skybody
