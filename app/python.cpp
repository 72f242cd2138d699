#include "app/python.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "core/base/installation.h"

namespace skybody {

std::string python_interpreter() {
  const char* chosen = std::getenv("SKYBODY_PYTHON");
  if (chosen != nullptr && *chosen != '\0') return chosen;
  const std::string configured = SKYBODY_DEFAULT_PYTHON;
  return access(configured.c_str(), X_OK) == 0 ? configured : "python3";
}

std::filesystem::path plot_script() {
  return shipped_data("scripts", "scripts") / "plot_flight.py";
}

void find_python_package() {
  // Scripts lie beside the package in the source tree, and in share/skybody of an installation.
  const std::filesystem::path package = shipped_data("scripts", "scripts").parent_path() / "python";
  std::error_code ignored;
  if (!std::filesystem::exists(package / "skybody", ignored)) return;
  const char* before = std::getenv("PYTHONPATH");
  const std::string rest = before != nullptr && *before != '\0' ? ":" + std::string(before) : "";
  setenv("PYTHONPATH", (package.string() + rest).c_str(), 1);
}

}  // namespace skybody
