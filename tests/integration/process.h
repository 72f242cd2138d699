// Runs programs for tests: directly, never through a shell.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace skybody::test {

/// How a program ended and what it wrote.
struct Outcome {
  int exit_code = -1;  ///< -1: a signal ended it
  int signal = 0;
  std::string out, err;
};

struct ProcessOptions {
  std::filesystem::path folder = ".";         ///< working directory
  std::vector<std::string> environment = {};  ///< NAME=VALUE, beside the present ones
  /// Asked every few milliseconds while the program runs; true sends SIGINT, once.
  std::function<bool()> interrupt_when = {};
};

/// Runs `program` to its end. Throws std::runtime_error if it cannot be started, or has not ended
/// after four minutes: it is then killed, since a test that ctest kills after five leaves it
/// behind.
Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                    const ProcessOptions& options = {});

/// The same for the `skybody` of this build.
Outcome run_skybody(const std::vector<std::string>& arguments, const ProcessOptions& options = {});

/// A folder that is removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Names of what lies in it, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

/// Lines without their ends.
std::vector<std::string> lines_of(const std::string& text);

}  // namespace skybody::test
