// skybody tune: hands its arguments to the Python package, which does the work.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "app/command.h"
#include "app/python.h"
#include "core/base/error.h"

namespace skybody {
namespace {

/// Becomes `python -m skybody.tune ARGUMENTS`, whose exit status is the program's.
int become_python(const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {python_interpreter(), "-m", "skybody.tune"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  find_python_package();
  execvp(words[0], words.data());
  throw Error("cannot start " + command[0] + ": " + std::strerror(errno) +
              "; name a Python that has the package skybody in SKYBODY_PYTHON");
}

}  // namespace

void add_tune_command(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("tune", "Fit gains of a chain of controllers to a vehicle");
  command->prefix_command();   // all that follows is Python's to read,
  command->set_help_flag("");  // --help too
  command->callback(
      [command, &chosen] { chosen = [command] { return become_python(command->remaining()); }; });
}

}  // namespace skybody
