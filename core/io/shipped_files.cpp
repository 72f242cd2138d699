#include "core/io/shipped_files.h"

#include <algorithm>

#include "core/base/installation.h"

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

/// Names of the YAML files of a folder within the scenarios, sorted.
std::vector<std::string> yaml_files(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry :
       fs::directory_iterator(shipped_data("scenarios", "scenarios") / folder, ignored)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::optional<fs::path> find_shipped_scenario(const std::string& name) {
  return find(name, name + ".yaml");
}

std::vector<std::string> shipped_scenarios() { return yaml_files("."); }

std::optional<fs::path> find_shipped_reference(const std::string& name) {
  return find(name, "references/" + name + ".yaml");
}

std::vector<std::string> shipped_references() { return yaml_files("references"); }

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
