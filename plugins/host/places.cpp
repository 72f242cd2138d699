#include "plugins/host/places.h"

#include <boost/dll/runtime_symbol_info.hpp>
#include <cstdlib>
#include <sstream>

namespace skybody {
namespace fs = std::filesystem;

fs::path library_folder() {
  boost::system::error_code failed;
  const boost::dll::fs::path here = boost::dll::this_line_location(failed);
  const fs::path file = failed ? fs::path("/proc/self/exe") : fs::path(here.string());
  std::error_code not_found;
  const fs::path real = fs::canonical(file, not_found);
  return (not_found ? fs::absolute(file) : real).parent_path();
}

fs::path shipped_plugin_folder() { return library_folder() / "skybody" / "plugins"; }

fs::path shipped_data(const std::string& name, const std::string& source_folder) {
  std::error_code ignored;
  // lib/ or lib/ARCHITECTURE/ of a prefix; bin/ of one where the library is linked statically.
  for (const char* up : {"..", "../.."}) {
    const fs::path installed =
        (library_folder() / up / "share" / "skybody" / name).lexically_normal();
    if (fs::is_directory(installed, ignored)) return installed;
  }
  const fs::path source = fs::path(SKYBODY_SOURCE_FOLDER) / source_folder;
  return fs::is_directory(source, ignored) ? source : fs::path();
}

std::vector<fs::path> default_search_path(const fs::path& scenario_folder) {
  std::vector<fs::path> path;
  if (const char* listed = std::getenv("SKYBODY_PLUGIN_PATH"); listed != nullptr) {
    std::istringstream entries(listed);
    for (std::string entry; std::getline(entries, entry, ':');) {
      if (!entry.empty()) path.emplace_back(entry);
    }
  }
  if (!scenario_folder.empty()) {
    path.push_back(scenario_folder);
    path.push_back(scenario_folder / "plugins");
  }
  path.push_back(shipped_plugin_folder());
  return path;
}

}  // namespace skybody
