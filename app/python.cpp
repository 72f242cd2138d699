#include "app/python.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "core/base/system/error.h"
#include "core/base/system/installation.h"
#include "core/version.h"

namespace skybody {
namespace {

/// The environment variable; empty if it is not set.
std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

rlim_t address_space() {
  rlimit limit{};
  return getrlimit(RLIMIT_AS, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

std::string interpreter() {
  if (const std::string chosen = variable("SKYBODY_PYTHON"); !chosen.empty()) return chosen;
  const std::string configured = SKYBODY_DEFAULT_PYTHON;
  return access(configured.c_str(), X_OK) == 0 ? configured : "python3";
}

}  // namespace

std::vector<std::string> python_command() { return {interpreter(), "-P"}; }

void set_python_environment() {
  // Scenarios are beside the package in the source tree, and in share/skybody of an installation.
  const std::filesystem::path package =
      shipped_data("scenarios", "scenarios").parent_path() / "python";
  std::error_code ignored;
  std::string path;
  if (std::filesystem::exists(package / "skybody", ignored)) path = package.string();
  std::istringstream entries(variable("PYTHONPATH"));
  for (std::string entry; std::getline(entries, entry, ':');) {
    if (!entry.empty()) path += (path.empty() ? "" : ":") + entry;
  }
  setenv("PYTHONPATH", path.c_str(), 1);
  setenv("SKYBODY_PROGRAM_VERSION", version(), 1);  // the package refuses another one
  if (address_space() != RLIM_INFINITY) setenv("OPENBLAS_NUM_THREADS", "1", 0);
}

void check_memory_for_python() {
  constexpr rlim_t kLeast = 256 << 20;  // [bytes]; NumPy and the package take 200 MB
  if (address_space() >= kLeast) return;
  throw Error("the address space is limited to " + std::to_string(address_space() >> 20) +
              " MiB (ulimit -v); Python needs " + std::to_string(kLeast >> 20) + " MiB or more");
}

}  // namespace skybody
