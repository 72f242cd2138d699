// The composition root: scenario file + plugins -> CompiledScenario.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"
#include "core/io/yaml/diagnostics.h"
#include "core/io/yaml/plugin_catalog.h"
#include "core/model/refused_files.h"

namespace skybody {

class PluginRegistry;

/// Inputs of compile_scenario().
struct LoadOptions {
  std::string scenario;                            ///< YAML file, or the name of a shipped scenario
  std::vector<std::string> overrides;              ///< "PATH=VALUE", in order
  std::vector<std::filesystem::path> plugin_path;  ///< searched before the default folders
  bool trust_scenario = false;        ///< also search the scenario's folder and its `plugins`
  RefusedFiles refused_plugins = {};  ///< not opened
  bool checked = false;               ///< checked mode, see CompiledScenario
  std::string reference = {};  ///< a reference that commands it, see reference_use.h; empty: none
  /// Called with each plugin's setup before its configure(); null: not called.
  std::function<void(SkybodyKind kind, const SkybodySetup& setup)> on_setup = nullptr;
};

/// The file of a scenario: `scenario` itself, or the shipped scenario of this name. A folder of the
/// same name does not hide a shipped scenario (`--out boom` creates one). The file may not exist.
std::string scenario_file(const std::string& scenario);

/// Reports the missing plugin folders among those of the options and the environment variable.
/// @returns whether all exist
bool check_plugin_path(const LoadOptions& options, Diagnostics& diagnostics);

/// Plugins found on the search path of `options` (see docs/plugins.md for the order).
std::shared_ptr<PluginRegistry> find_plugins(const LoadOptions& options);

/// The registry as a catalog for the scenario reader. Shares ownership of the registry.
std::unique_ptr<PluginCatalog> make_catalog(std::shared_ptr<const PluginRegistry> registry);

/// plugin_hint() for plugins in the default folders.
std::string plugin_hint(const std::string& name);

/// Reads the scenario, configures its plugins and builds the world.
/// @returns null if `diagnostics` has errors afterwards; warnings alone do not prevent loading
std::shared_ptr<const CompiledScenario> compile_scenario(const LoadOptions& options,
                                                         Diagnostics& diagnostics);

/// The same with plugins found before, for callers that load many scenarios.
std::shared_ptr<const CompiledScenario> compile_scenario(
    const LoadOptions& options, const std::shared_ptr<const PluginRegistry>& registry,
    Diagnostics& diagnostics);

/// The same with an exception in place of diagnostics. Warnings are not reported.
/// @throws InputError with all messages
std::shared_ptr<const CompiledScenario> compile_scenario(const LoadOptions& options);

}  // namespace skybody
