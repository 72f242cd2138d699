// The composition root: scenario file + plugins -> CompiledScenario.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"
#include "core/io/diagnostics.h"
#include "core/io/plugin_catalog.h"
#include "core/model/refused_files.h"

namespace skybody {

class PluginRegistry;

/// What to load.
struct LoadOptions {
  std::string scenario;                            ///< YAML file, or the name of a shipped scenario
  std::vector<std::string> overrides;              ///< "PATH=VALUE", in order
  std::vector<std::filesystem::path> plugin_path;  ///< searched before the default places
  bool trust_scenario = false;  ///< search the scenario's folder and its `plugins`, too
  RefusedFiles refused_plugins = {};
  bool checked = false;        ///< checked mode, see CompiledScenario
  std::string reference = {};  ///< a reference that flies it, see reference_use.h; empty: none
};

/// The file that `scenario` means: itself, or that of a shipped scenario of this name, which a
/// folder does not hide (`--out boom` makes one). Whether it is there is not looked at.
std::string scenario_file(const std::string& scenario);

/// Says which folders for plugins, of those that the options and the environment name, are not
/// there. @returns whether all are
bool check_plugin_path(const LoadOptions& options, Diagnostics& diagnostics);

/// Plugins found on the search path of `options` (see docs/plugins.md for the order).
std::shared_ptr<PluginRegistry> find_plugins(const LoadOptions& options);

/// The registry as the scenario reader sees it. Keeps it alive.
std::unique_ptr<PluginCatalog> make_catalog(std::shared_ptr<const PluginRegistry> registry);

/// plugin_hint() of plugins in the default places.
std::string plugin_hint(const std::string& name);

/// Reads the scenario, configures its plugins and builds the world.
/// @returns null if `diagnostics` has errors afterwards; warnings alone do not prevent loading
std::shared_ptr<const CompiledScenario> compile_scenario(const LoadOptions& options,
                                                         Diagnostics& diagnostics);

/// The same with plugins that were found before, for callers who load many scenarios.
std::shared_ptr<const CompiledScenario> compile_scenario(
    const LoadOptions& options, const std::shared_ptr<const PluginRegistry>& registry,
    Diagnostics& diagnostics);

/// The same for callers who want an exception.
/// @throws InputError with all messages
std::shared_ptr<const CompiledScenario> compile_scenario(const LoadOptions& options);

}  // namespace skybody
