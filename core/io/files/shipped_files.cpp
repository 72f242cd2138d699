#include "core/io/files/shipped_files.h"

#include <algorithm>

#include "core/base/system/installation.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> find(const std::string& name, const std::string& relative) {
  constexpr const char* kLetters = "abcdefghijklmnopqrstuvwxyz0123456789_";
  if (name.empty() || name.find_first_not_of(kLetters) != std::string::npos) return std::nullopt;
  const fs::path file = shipped_data("scenarios", "scenarios") / relative;
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  return file;
}

/// Names of the files in a subfolder of the scenarios, without `extension`, sorted.
std::vector<std::string> names_in(const std::string& folder, const std::string& extension) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry :
       fs::directory_iterator(shipped_data("scenarios", "scenarios") / folder, ignored)) {
    if (entry.path().extension() == extension) names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::optional<fs::path> find_shipped_scenario(const std::string& name) {
  return find(name, name + ".yaml");
}

std::vector<std::string> shipped_scenarios() { return names_in(".", ".yaml"); }

std::optional<fs::path> find_shipped_reference(const std::string& name) {
  return find(name, "references/" + name + ".yaml");
}

std::vector<std::string> shipped_references() { return names_in("references", ".yaml"); }

std::optional<fs::path> find_shipped_policy(const std::string& name) {
  return find(name, "policies/" + name + ".h5");
}

std::vector<std::string> shipped_policies() { return names_in("policies", ".h5"); }

std::optional<fs::path> find_shipped_model(const std::string& name) {
  return find(name, "models/" + name + "/" + name + ".urdf");
}

std::vector<std::string> shipped_models() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry :
       fs::directory_iterator(shipped_data("scenarios", "scenarios") / "models", ignored)) {
    const std::string name = entry.path().filename().string();
    if (find_shipped_model(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace skybody
