#include "core/plugin_host/search_path.h"

#include <cstdlib>
#include <sstream>

#include "core/base/system/installation.h"

namespace skybody {
namespace fs = std::filesystem;

fs::path shipped_plugin_folder() { return library_folder() / "skybody" / "plugins"; }

std::vector<fs::path> scenario_plugin_folders(const fs::path& scenario) {
  std::error_code failed;
  const fs::path given = fs::absolute(scenario, failed).parent_path();
  if (failed) return {};
  const fs::path real = fs::canonical(given, failed);
  const fs::path& folder = failed ? given : real;
  return {folder, folder / "plugins"};
}

std::vector<fs::path> environment_search_path() {
  std::vector<fs::path> path;
  if (const char* listed = std::getenv("SKYBODY_PLUGIN_PATH"); listed != nullptr) {
    std::istringstream entries(listed);
    for (std::string entry; std::getline(entries, entry, ':');) {
      if (!entry.empty()) path.emplace_back(entry);
    }
  }
  return path;
}

std::vector<fs::path> default_search_path() {
  std::vector<fs::path> path = environment_search_path();
  path.push_back(shipped_plugin_folder());
  return path;
}

}  // namespace skybody
