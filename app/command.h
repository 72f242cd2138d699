// The sub-commands. Each add_*_command declares one to CLI11 and, when it is given, leaves what is
// to be done in `chosen`; main runs that once the whole command line has been found good.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace skybody {

/// Exit statuses of the program.
enum ExitStatus : int {
  kExitDone = 0,
  kExitDiffers = 1,  ///< replay: the runs are not the same
  kExitError = 2,    ///< the user's input: command line, files, plugins, places to write to
  kExitBug = 3,      ///< ours
  kExitSignal = 128  ///< plus the signal: 130 after Ctrl-C
};

/// Does the command's work. @returns the exit status
using Action = std::function<int()>;

void add_run_command(CLI::App& app, Action& chosen);
void add_check_command(CLI::App& app, Action& chosen);
void add_hash_command(CLI::App& app, Action& chosen);
void add_replay_command(CLI::App& app, Action& chosen);
void add_bench_command(CLI::App& app, Action& chosen);
void add_plugins_command(CLI::App& app, Action& chosen);
void add_schema_command(CLI::App& app, Action& chosen);
void add_new_command(CLI::App& app, Action& chosen);

}  // namespace skybody
