// Runs programs for tests: directly, never through a shell.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace skybody::test {

/// A program's exit status and output.
struct Outcome {
  int exit_code = -1;  ///< -1: ended by a signal
  int signal = 0;
  std::string out, err;
};

struct ProcessOptions {
  std::filesystem::path folder = ".";         ///< working directory
  std::vector<std::string> environment = {};  ///< NAME=VALUE, in addition to the present variables
  /// Called every few milliseconds while the program runs; true sends SIGINT, once.
  std::function<bool()> interrupt_when = {};
};

/// Runs `program` to its end. Throws std::runtime_error if the program cannot be started, or if it
/// still runs after four minutes. It is then killed, because a test that ctest kills after five
/// minutes would leave it running.
Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                    const ProcessOptions& options = {});

/// The same for the `skybody` of this build.
Outcome run_skybody(const std::vector<std::string>& arguments, const ProcessOptions& options = {});

/// A temporary folder; the destructor removes it with its content.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Names of the folder's entries, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

/// Lines without their line ends.
std::vector<std::string> lines_of(const std::string& text);

}  // namespace skybody::test
