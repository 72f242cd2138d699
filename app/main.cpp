// The program `skybody`: reads the command line, runs one sub-command, and turns failures into one
// message and an exit status.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <string>

#include "app/arguments.h"
#include "app/commands/command.h"
#include "app/plugin_exit.h"
#include "app/report/report.h"
#include "core/version.h"

namespace skybody {
namespace {

constexpr const char* kMainFooter =
    "Examples:\n"
    "  skybody run hover --policy hold\n"
    "  skybody check hover --set robots.quad.pose.position=[0,0,2]\n"
    "  skybody new controller my_law\n"
    "`skybody COMMAND --help` lists the options of a command. Exit status: 0 done, 2 invalid "
    "input.";

/// Warnings go to stderr, in colour on a terminal.
void set_up_log() {
  auto log = spdlog::stderr_color_mt("skybody");
  log->set_pattern("%^%l%$: %v");
  spdlog::set_default_logger(log);
}

void declare_commands(CLI::App& app, Action& chosen) {
  app.footer(kMainFooter);
  app.set_version_flag("--version", std::string("skybody ") + version());
  app.require_subcommand(1);
  add_run_command(app, chosen);
  add_check_command(app, chosen);
  add_hash_command(app, chosen);
  add_replay_command(app, chosen);
  add_bench_command(app, chosen);
  add_scenarios_command(app, chosen);
  add_plugins_command(app, chosen);
  add_modes_command(app, chosen);
  add_plan_command(app, chosen);
  add_schema_command(app, chosen);
  add_python_commands(app, chosen);
  add_onboard_command(app, chosen);
  add_new_command(app, chosen);
}

int run_program(int count, const char* const* arguments) {
  set_up_log();
  name_plugins_that_end_the_program();
  CLI::App app("Skybody, a deterministic simulator for learning to fly", "skybody");
  Action chosen;
  declare_commands(app, chosen);
  const std::string wrong_name = check_command_name(app, count, arguments);
  if (!wrong_name.empty()) return report_error("error: " + wrong_name);
  try {
    app.parse(count, arguments);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    return report_error("error: " + describe_usage_error(app, error));
  }
  const CommandRun running;
  return run_and_report(chosen);
}

}  // namespace
}  // namespace skybody

int main(int count, char** arguments) { return skybody::run_program(count, arguments); }
