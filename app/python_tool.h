// Python programs that make files for commands of this program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skybody {

/// A module of the package skybody that makes files, and prints a line `WORD PATH` for each.
struct PythonTool {
  const char* module;
  const char* word;      ///< with a space at its end
  const char* packages;  ///< that it also needs, in words, for a message
};

/// The result of make_files().
struct MadeFiles {
  std::vector<std::filesystem::path> files;
  std::string failure;  ///< reason why some or all are missing; empty: success
};

/// Runs a tool. The interpreter is $SKYBODY_PYTHON, otherwise the one chosen when Skybody was
/// configured, otherwise python3 on PATH. It is started directly, never through a shell.
MadeFiles make_files(const PythonTool& tool, const std::vector<std::string>& arguments);

}  // namespace skybody
