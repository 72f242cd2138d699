// skybody check: reads a scenario with all files that it names, and reports errors and warnings.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "app/commands/check_flight.h"
#include "app/commands/check_reference.h"
#include "app/commands/command.h"
#include "app/plugin_child.h"
#include "app/report/text_table.h"
#include "app/scenario_options.h"
#include "core/base/math/hash.h"
#include "core/env/state_values.h"
#include "core/env/value_names.h"
#include "core/io/files/text.h"

namespace skybody {
namespace {

constexpr const char* kCheckFooter =
    "Reads the scenario with all its files and flies a few steps in checked mode, which checks "
    "the\n"
    "accesses and outputs of plugins.\n"
    "Messages go to stderr as file:line:column: error: MESSAGE. Exit status: 0 no errors, perhaps\n"
    "warnings; 2 errors.\n"
    "Examples:\n"
    "  skybody check hover\n"
    "  skybody check hover --parameters\n"
    "  skybody check hover --reference circle:peak_speed=9";

struct CheckOptions {
  LoadOptions load;
  bool parameters = false;
  bool columns = false;
  bool states = false;
};

std::string count(std::size_t n, const char* one, const char* several) {
  return std::to_string(n) + " " + (n == 1 ? one : several);
}

std::string describe(const CompiledScenario& compiled) {
  const Scenario& scenario = compiled.scenario();
  const World& world = compiled.world();
  return "ok: " + scenario.name + ": " + count(scenario.robots.size(), "robot", "robots") + ", " +
         count(world.bodies.size(), "body", "bodies") + ", " +
         count(world.rotors.size(), "rotor", "rotors") + ", " +
         std::to_string(compiled.observation_size()) + " observations, " +
         std::to_string(compiled.action_size()) + " actions, scenario hash " +
         to_hex(scenario.hash);
}

std::string shape_text(const std::vector<int>& shape) {
  std::string text;
  for (const int extent : shape) {
    text += (text.empty() ? "" : " x ") + std::to_string(extent);
  }
  return text;
}

/// The observer of a column: a robot, or all; or only a critic.
std::string owner_text(const CompiledScenario& compiled, const ObservationColumn& column) {
  if (column.privileged) return "critic";
  if (column.robot < 0) return "all";
  return compiled.scenario().robots[static_cast<std::size_t>(column.robot)].name;
}

std::string parameter_table(const CompiledScenario& compiled) {
  TextTable table({"parameter", "unit", "nominal", "min", "max"});
  for (const EnvParam& param : compiled.layout().param_info) {
    table.add({param.path, param.unit, format_number(param.nominal), format_number(param.min),
               format_number(param.max)});
  }
  return table.to_string();
}

std::string column_table(const CompiledScenario& compiled) {
  TextTable table({"column", "unit", "type", "shape", "low", "high", "from", "for", "meaning"});
  for (const ObservationColumn& column : compiled.columns()) {
    table.add({column.name, column.unit, info_of(column.type).name, shape_text(column.shape),
               format_number(column.low), format_number(column.high), source_of(compiled, column),
               owner_text(compiled, column), column.doc});
  }
  return table.to_string();
}

std::string state_table(const CompiledScenario& compiled) {
  TextTable table({"state value", "unit", "shape", "frame", "meaning"});
  for (const StateValue& value : compiled.state_values().all()) {
    table.add({value.path, value.unit, shape_text(value.shape), value.frame, value.doc});
  }
  return table.to_string();
}

int check(CheckOptions options, const RefusedFiles& refused) {
  options.load.refused_plugins = refused;
  options.load.checked = true;
  const auto compiled = load_and_warn(options.load);
  Diagnostics diagnostics;
  fly_for_a_moment(compiled, diagnostics);
  if (!diagnostics.has_errors()) warn_of_limited_references(compiled, diagnostics);
  std::fputs(diagnostics.to_string().c_str(), stderr);
  if (diagnostics.has_errors()) return kExitError;
  std::printf("%s\n", describe(*compiled).c_str());
  if (options.parameters) std::printf("\n%s", parameter_table(*compiled).c_str());
  if (options.columns) std::printf("\n%s", column_table(*compiled).c_str());
  if (options.states) std::printf("\n%s", state_table(*compiled).c_str());
  return kExitDone;
}

}  // namespace

void add_check_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("check", "Report the errors of a scenario");
  const auto options = std::make_shared<CheckOptions>();
  command->footer(kCheckFooter);
  add_scenario_options(*command, options->load);
  add_reference(*command, options->load);
  command->add_flag("--parameters", options->parameters,
                    "List all randomizable values: path, unit, nominal, min, max");
  command->add_flag(
      "--columns", options->columns,
      "List the observation's columns: name, unit, type, shape, bounds, source, observer, meaning");
  command->add_flag("--states", options->states,
                    "List the readable values of the state: path, unit, shape, frame, meaning");
  command->callback([options, &chosen] {
    chosen = [options] {
      return run_in_child([&](const RefusedFiles& refused) { return check(*options, refused); });
    };
  });
}

}  // namespace skybody
