#include "app/python_tool.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "app/python.h"

extern char** environ;

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// Result of a program that has ended.
struct Outcome {
  int spawn_error = 0;  ///< errno; 0: it was started
  int status = 0;       ///< from waitpid
  std::string output;   ///< stdout and stderr
};

std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t count = read(descriptor, buffer.data(), buffer.size());
    if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EINTR)) return text;
  }
}

int spawn(const std::vector<std::string>& command, int output, pid_t& child) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  const int error =
      posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

Outcome run(const std::vector<std::string>& command) {
  Outcome outcome;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {errno, 0, ""};
  pid_t child = 0;
  outcome.spawn_error = spawn(command, ends[1], child);
  close(ends[1]);
  if (outcome.spawn_error == 0) {
    outcome.output = read_all(ends[0]);
    while (waitpid(child, &outcome.status, 0) < 0 && errno == EINTR) continue;
  }
  close(ends[0]);
  return outcome;
}

/// The paths among the tool's output lines; `last` is set to the last other line.
std::vector<fs::path> paths_in(const PythonTool& tool, const std::string& output,
                               std::string& last) {
  std::vector<fs::path> files;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(tool.word, 0) == 0) {
      files.emplace_back(line.substr(line.find_first_not_of(' ', std::strlen(tool.word))));
    } else if (!line.empty()) {
      last = line;
    }
  }
  return files;
}

}  // namespace

MadeFiles make_files(const PythonTool& tool, const std::vector<std::string>& arguments) {
  std::vector<std::string> command = python_command();
  command.insert(command.end(), {"-m", tool.module});
  command.insert(command.end(), arguments.begin(), arguments.end());
  set_python_environment();
  const Outcome outcome = run(command);
  if (outcome.spawn_error != 0) {
    return {{},
            "cannot start " + command[0] + ": " + std::strerror(outcome.spawn_error) +
                "; name a Python that has the package skybody, " + tool.packages +
                " in SKYBODY_PYTHON"};
  }
  std::string last;
  MadeFiles made{paths_in(tool, outcome.output, last), ""};
  if (outcome.status != 0)
    made.failure = last.empty() ? tool.module + std::string(" failed") : last;
  return made;
}

}  // namespace skybody
