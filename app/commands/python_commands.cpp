// Commands implemented in Python: each passes its arguments on.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "app/commands/command.h"
#include "app/python.h"
#include "core/base/system/error.h"

namespace skybody {
namespace {

struct PythonCommand {
  const char* name;
  const char* module;
  const char* help;
};

constexpr PythonCommand kCommands[] = {
    {"train", "skybody.train", "Train a policy in a scenario, reproducibly"},
    {"tune", "skybody.tune", "Fit the gains of a chain of controllers to a vehicle"},
    {"render", "skybody.look", "Draw flights as films or pictures"},
    {"view", "skybody.view", "Show flights, or a running simulation, in a browser"},
    {"ros1", "skybody.ros1", "Run a scenario as a node of ROS 1"},
    {"ros2", "skybody.ros2", "Run a scenario as a node of ROS 2"},
    {"sitl", "skybody.sitl", "Let ArduPilot, PX4 or Betaflight fly a robot, in lockstep"},
    {"export", "skybody.exports", "Write a flight or a policy in a format of other programs"},
    {"import", "skybody.imports", "Make a flight log from the log of a real flight"},
    {"identify", "skybody.identify", "Identify a vehicle from recorded flights"},
    {"plot", "skybody.plot", "Draw the flights of a log, as PNG, PDF or SVG"},
};

/// Replaces this process by `python -P -m MODULE ARGUMENTS`, whose exit status becomes the
/// program's.
int become_python(const char* module, const std::vector<std::string>& arguments) {
  std::vector<std::string> command = python_command();
  command.insert(command.end(), {"-m", module});
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  check_memory_for_python();
  set_python_environment();
  execvp(words[0], words.data());
  throw Error("cannot start " + command[0] + ": " + std::strerror(errno) +
              "; name a Python that has the package skybody in SKYBODY_PYTHON");
}

}  // namespace

void add_python_commands(CLI::App& app, Action& chosen) {
  for (const PythonCommand& row : kCommands) {
    CLI::App* command = app.add_subcommand(row.name, row.help);
    command->prefix_command();   // all following arguments are for Python,
    command->set_help_flag("");  // --help too
    command->callback([command, module = row.module, &chosen] {
      chosen = [command, module] { return become_python(module, command->remaining()); };
    });
  }
}

}  // namespace skybody
