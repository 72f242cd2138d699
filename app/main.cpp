// The program `skybody`: reads the command line, runs one sub-command, and turns failures into one
// message and an exit status.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <exception>
#include <string>

#include "app/arguments.h"
#include "app/command.h"
#include "app/output.h"
#include "core/io/diagnostics.h"
#include "core/model/marked_error.h"
#include "core/version.h"

namespace skybody {
namespace {

constexpr const char* kFooter =
    "Examples:\n"
    "  skybody run scenarios/hover.yaml --policy hold\n"
    "  skybody check scenarios/hover.yaml --set robots.quad.pose.position=[0,0,2]\n"
    "  skybody new controller my_law\n"
    "`skybody COMMAND --help` tells more. Exit status: 0 done, 2 an error that you can mend.";

/// Warnings go to stderr, in colour on a terminal.
void set_up_log() {
  auto log = spdlog::stderr_color_mt("skybody");
  log->set_pattern("%^%l%$: %v");
  spdlog::set_default_logger(log);
}

void declare_commands(CLI::App& app, Action& chosen) {
  app.footer(kFooter);
  app.set_version_flag("--version", std::string("skybody ") + version());
  app.require_subcommand(1);
  add_run_command(app, chosen);
  add_check_command(app, chosen);
  add_hash_command(app, chosen);
  add_replay_command(app, chosen);
  add_bench_command(app, chosen);
  add_plugins_command(app, chosen);
  add_schema_command(app, chosen);
  add_new_command(app, chosen);
}

int print_error(const std::string& message) {
  std::fflush(stdout);
  std::fprintf(stderr, "%s\n", message.c_str());
  return kExitError;
}

int print_diagnostics(const InputError& error) {
  std::string text;
  for (const Diagnostic& diagnostic : error.diagnostics()) {
    text += (text.empty() ? "" : "\n") + diagnostic.to_string();
  }
  return print_error(text);
}

/// Runs what the command line chose; every failure becomes one message.
int run_chosen(const Action& chosen) {
  try {
    const int status = chosen();
    flush_output();
    return status;
  } catch (const InputError& error) {
    return print_diagnostics(error);
  } catch (const MarkedError& error) {
    return print_error(Diagnostic{Severity::kError, error.mark(), error.what()}.to_string());
  } catch (const Error& error) {
    return print_error(std::string("error: ") + error.what());
  } catch (const std::bad_alloc&) {
    return print_error("error: out of memory");
  } catch (const std::exception& error) {
    print_error(std::string("internal error: ") + error.what());
    return kExitBug;
  }
}

int run_program(int count, const char* const* arguments) {
  set_up_log();
  CLI::App app("Skybody, a deterministic simulator for learning to fly", "skybody");
  Action chosen;
  declare_commands(app, chosen);
  const std::string wrong_name = check_command_name(app, count, arguments);
  if (!wrong_name.empty()) return print_error("error: " + wrong_name);
  try {
    app.parse(count, arguments);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    return print_error("error: " + describe_usage_error(app, error));
  }
  return run_chosen(chosen);
}

}  // namespace
}  // namespace skybody

int main(int count, char** arguments) { return skybody::run_program(count, arguments); }
