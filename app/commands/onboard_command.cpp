// `skybody onboard`: becomes the program beside this one, which vehicles run by itself.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/commands/command.h"
#include "app/python.h"
#include "core/base/system/error.h"

namespace skybody {
namespace {

/// skybody_onboard of the folder of this program.
std::filesystem::path program() {
  std::error_code ignored;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", ignored);
  return self.parent_path() / "skybody_onboard";
}

/// Replaces this process. With --ros2 it becomes the bridge in Python, which starts the program.
int become_onboard(std::vector<std::string> arguments) {
  std::vector<std::string> command = {program().string()};
  const auto bridge = std::find(arguments.begin(), arguments.end(), "--ros2");
  if (bridge != arguments.end()) {
    arguments.erase(bridge);
    command = python_command();
    command.insert(command.end(), {"-m", "skybody.onboard"});
    set_python_environment();
    setenv("SKYBODY_ONBOARD", program().c_str(), 0);
  }
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  execvp(words[0], words.data());
  throw Error("cannot start " + command[0] + ": " + std::strerror(errno) +
              "; build it (`./dev build`)");
}

}  // namespace

void add_onboard_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("onboard", "Fly a policy on a vehicle, from a mission");
  command->prefix_command();   // all following arguments are for the program,
  command->set_help_flag("");  // --help too
  command->callback(
      [command, &chosen] { chosen = [command] { return become_onboard(command->remaining()); }; });
}

}  // namespace skybody
