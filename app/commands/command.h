// The sub-commands. Each add_*_command declares one to CLI11. If it is selected, it stores its work
// in `chosen`, which main runs after the whole command line has been validated.
#pragma once

#include "app/command_work.h"

namespace CLI {
class App;
}

namespace skybody {

void add_run_command(CLI::App& app, Action& chosen);
void add_check_command(CLI::App& app, Action& chosen);
void add_hash_command(CLI::App& app, Action& chosen);
void add_replay_command(CLI::App& app, Action& chosen);
void add_bench_command(CLI::App& app, Action& chosen);
void add_onboard_command(CLI::App& app, Action& chosen);
void add_plugins_command(CLI::App& app, Action& chosen);
void add_modes_command(CLI::App& app, Action& chosen);
void add_plan_command(CLI::App& app, Action& chosen);
void add_scenarios_command(CLI::App& app, Action& chosen);
void add_schema_command(CLI::App& app, Action& chosen);
void add_python_commands(CLI::App& app, Action& chosen);
void add_new_command(CLI::App& app, Action& chosen);

}  // namespace skybody
