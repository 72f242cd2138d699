// skybody modes: control levels, the controllers between them, and the possible inputs for a
// policy.
#include <CLI/CLI.hpp>
#include <algorithm>

#include "app/commands/command.h"
#include "app/plugin_child.h"
#include "app/report/mode_tables.h"
#include "app/report/output.h"
#include "app/scenario_options.h"
#include "core/assemble/controller_survey.h"

namespace skybody {
namespace {

constexpr const char* kModesFooter =
    "With a scenario: the control chains of its robots and teams, level by level, the meaning of\n"
    "actions -1 and +1 at each level, and all possible modes of each robot. A policy may enter at\n"
    "any level: omit the controllers before it. Without a scenario: all levels and controllers\n"
    "for a quadrotor with a joint; sizes and ranges differ for other vehicles.\n"
    "docs/control-modes.md defines the levels.\n"
    "Examples:\n"
    "  skybody modes hover\n"
    "  skybody modes\n"
    "  skybody modes --json | python3 -m json.tool\n"
    "  skybody run hover --set 'robots.quad.controllers=[{plugin: ctbr}]'";

struct ModesOptions {
  LoadOptions load;
  bool json = false;
};

std::vector<const PluginEntry*> usable_controllers(const PluginRegistry& registry) {
  std::vector<const PluginEntry*> entries;
  for (const PluginEntry* entry : registry.open_all()) {
    if (entry->kind == SKYBODY_CONTROLLER && entry->failure.empty()) entries.push_back(entry);
  }
  std::sort(entries.begin(), entries.end(),
            [](const PluginEntry* a, const PluginEntry* b) { return a->name < b->name; });
  return entries;
}

/// The modes of each robot with controllers.
std::vector<RobotModes> modes_of(const CompiledScenario& compiled, const PluginRegistry& registry) {
  const std::vector<const PluginEntry*> entries = usable_controllers(registry);
  std::vector<RobotModes> all;
  for (int r = 0; r < static_cast<int>(compiled.scenario().robots.size()); ++r) {
    const RobotUse& robot = compiled.scenario().robots[static_cast<std::size_t>(r)];
    const bool is_commanded =
        std::any_of(compiled.chains().begin(), compiled.chains().end(),
                    [r](const ControllerChain& chain) { return chain.robot == r; });
    if (is_commanded) {
      all.push_back({robot.name, survey_controllers(entries, compiled.world(), r)});
    }
  }
  return all;
}

int print_modes(ModesOptions options, const RefusedFiles& refused) {
  options.load.refused_plugins = refused;
  const std::shared_ptr<const PluginRegistry> registry = open_plugins(options.load);
  if (options.load.scenario.empty()) {
    const ControllerSurvey survey =
        survey_controllers(usable_controllers(*registry), survey_vehicle(), 0);
    print(options.json ? survey_json(survey) : survey_text(survey));
    return kExitDone;
  }
  const auto compiled = load_and_warn(options.load);
  const std::vector<RobotModes> robots = modes_of(*compiled, *registry);
  print(options.json ? chains_json(*compiled, robots) : chains_text(*compiled, robots));
  return kExitDone;
}

}  // namespace

void add_modes_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand(
      "modes", "Show the levels of control and the possible inputs for a policy");
  const auto options = std::make_shared<ModesOptions>();
  command->footer(kModesFooter);
  add_scenario_options(*command, options->load);
  command->get_option("SCENARIO")->required(false);
  command->add_flag("--json", options->json, "Print JSON, for programs");
  command->callback([options, &chosen] {
    chosen = [options] {
      return run_in_child(
          [&](const RefusedFiles& refused) { return print_modes(*options, refused); });
    };
  });
}

}  // namespace skybody
