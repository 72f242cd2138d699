#include "app/scenario_options.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/plugin_host/registry.h"

namespace skybody {

void add_plugin_path(CLI::App& command, LoadOptions& options) {
  command
      .add_option("--plugin-path", options.plugin_path,
                  "Folder to search for plugins first; may be repeated")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory.description(""))
      ->expected(1)
      ->allow_extra_args(false)
      ->take_all();
}

void add_trust_scenario(CLI::App& command, LoadOptions& options) {
  command.add_flag("--trust-scenario", options.trust_scenario,
                   "Also search the scenario's folder and its subfolder plugins for plugins");
}

void add_scenario_options(CLI::App& command, LoadOptions& options) {
  command.add_option("SCENARIO", options.scenario, "YAML file, or the name of a shipped scenario")
      ->required()
      ->type_name("");
  command
      .add_option("--set", options.overrides,
                  "Override one value of the scenario, such as stepping.dt=0.002; may be repeated")
      ->type_name("PATH=VALUE")
      ->expected(1)
      ->allow_extra_args(false)
      ->delimiter('\0')
      ->take_all();
  add_plugin_path(command, options);
  add_trust_scenario(command, options);
}

void add_reference(CLI::App& command, LoadOptions& options) {
  command
      .add_option("--reference", options.reference,
                  "Fly a reference instead of a policy: the name of a shipped one or a YAML file, "
                  "and its parameters")
      ->type_name("NAME[:KEY=VALUE,...]");
}

void add_checked(CLI::App& command, LoadOptions& options) {
  command.add_flag("--checked", options.checked,
                   "Check the accesses and outputs of plugins: slower, the same bits");
}

std::shared_ptr<PluginRegistry> open_plugins(const LoadOptions& options) {
  Diagnostics diagnostics;
  if (!check_plugin_path(options, diagnostics)) throw InputError(diagnostics.all());
  std::shared_ptr<PluginRegistry> registry = find_plugins(options);
  registry->open_all();
  return registry;
}

std::shared_ptr<const CompiledScenario> load_and_warn(const LoadOptions& options) {
  Diagnostics diagnostics;
  std::shared_ptr<const CompiledScenario> compiled = compile_scenario(options, diagnostics);
  if (diagnostics.has_errors()) throw InputError(diagnostics.all());
  std::fputs(diagnostics.to_string().c_str(), stderr);
  return compiled;
}

}  // namespace skybody
