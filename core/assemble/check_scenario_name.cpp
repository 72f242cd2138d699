#include "core/assemble/check_scenario_name.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/io/files/missing_file.h"
#include "core/io/files/shipped_files.h"
#include "core/io/files/text.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr const char* kListed = "`skybody scenarios` lists the shipped ones";

constexpr const char* kRotorsFile = "rotors.yaml";

bool is_rotors_file(const fs::path& file) { return file.filename() == kRotorsFile; }

/// Files of other kinds that users give in place of a scenario.
struct OtherKind {
  std::vector<std::string> extensions;  ///< or the file's name
  const char* what;
  const char* use;
};

const std::vector<OtherKind>& other_kinds() {
  static const std::vector<OtherKind> kinds = {
      {{".urdf", ".xacro", ".sdf", ".xml"},
       "a robot's model",
       "a scenario names it as the `model` of a robot (docs/own_vehicle.md)"},
      {{".h5", ".hdf5"},
       "an HDF5 file",
       "a flight log is for `skybody plot`, a recording for `skybody replay`, a policy for "
       "`skybody run SCENARIO --policy FILE`"},
      {{".so"}, "a plugin's library", "a scenario names its plugins (docs/plugins.md)"},
      {{kRotorsFile}, "a rotors file", "a scenario names the URDF beside it (docs/rotors.md)"},
      {{".py"}, "a Python program", "start it with Python"},
  };
  return kinds;
}

std::string other_kind(const fs::path& file) {
  const std::string extension = is_rotors_file(file) ? kRotorsFile : file.extension().string();
  for (const OtherKind& kind : other_kinds()) {
    const auto& known = kind.extensions;
    if (std::find(known.begin(), known.end(), extension) == known.end()) continue;
    return std::string(kind.what) + "; a scenario, which is a YAML file, is needed: " + kind.use;
  }
  return "";
}

/// The first YAML file of a folder in the order of names; empty if there is none.
std::string scenario_in(const fs::path& folder) {
  std::string first;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string file = entry.path().string();
    if (entry.path().extension() != ".yaml" || is_rotors_file(file)) continue;
    if (first.empty() || file < first) first = file;
  }
  return first;
}

std::string missing_scenario(const std::string& scenario) {
  if (!is_identifier(scenario)) {
    return "the file does not exist; " + missing_file_hint(scenario, kListed, shipped_scenarios());
  }
  const std::string nowhere = "neither a file nor a shipped scenario";
  if (const std::string hint = plugin_hint(scenario); !hint.empty()) {
    return nowhere + hint + "; `skybody plugins` and `skybody modes` tell more";
  }
  const std::string near = closest(scenario, shipped_scenarios());
  return nowhere + (near.empty() ? "" : "; did you mean `" + near + "`?") + "; " + kListed;
}

/// The reason why `scenario` cannot be one; empty: it may be.
std::string problem_of(const std::string& scenario) {
  const fs::path file = scenario_file(scenario);
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return missing_scenario(scenario);
  if (!fs::is_directory(file, ignored)) return other_kind(file);
  const std::string inside = scenario_in(file);
  return "a folder; give the YAML file of a scenario" +
         (inside.empty() ? "" : ", such as " + inside);
}

}  // namespace

bool check_scenario_name(const std::string& scenario, Diagnostics& diagnostics) {
  if (scenario.empty()) {
    diagnostics.error({},
                      "no scenario is named; give a YAML file or the name of a shipped scenario");
    return false;
  }
  const std::string problem = problem_of(scenario);
  if (!problem.empty()) diagnostics.error({scenario, 0, 0}, problem);
  return problem.empty();
}

}  // namespace skybody
