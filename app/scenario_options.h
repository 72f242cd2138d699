// The options that select a scenario, shared by the commands that load one.
#pragma once

#include <memory>

#include "core/assemble/compile_scenario.h"

namespace CLI {
class App;
}

namespace skybody {

/// Declares SCENARIO, --set, --plugin-path and --trust-scenario.
void add_scenario_options(CLI::App& command, LoadOptions& options);
/// Declares only --plugin-path.
void add_plugin_path(CLI::App& command, LoadOptions& options);

/// Declares only --trust-scenario.
void add_trust_scenario(CLI::App& command, LoadOptions& options);

/// Declares --reference.
void add_reference(CLI::App& command, LoadOptions& options);

/// Declares --checked.
void add_checked(CLI::App& command, LoadOptions& options);

/// All plugins on the search path, opened. @throws InputError if a folder does not exist
std::shared_ptr<PluginRegistry> open_plugins(const LoadOptions& options);

/// Loads a scenario and prints its warnings.
/// @throws InputError with errors and warnings
std::shared_ptr<const CompiledScenario> load_and_warn(const LoadOptions& options);

}  // namespace skybody
