#include "core/io/files/shipped_files.h"

#include <algorithm>

#include "core/base/system/installation.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModels = "models";
constexpr const char* kReferences = "references";

fs::path root() { return shipped_data("scenarios", "scenarios"); }

/// The file if `name` is a name, not a path, and the file exists.
std::optional<fs::path> existing(const std::string& name, const fs::path& file) {
  constexpr const char* kLetters = "abcdefghijklmnopqrstuvwxyz0123456789_";
  if (name.empty() || name.find_first_not_of(kLetters) != std::string::npos) return std::nullopt;
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  return file;
}

/// Names of the files in `folder` without their extension, appended.
void add_names(const fs::path& folder, const std::string& extension,
               std::vector<std::string>& names) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == extension) names.push_back(entry.path().stem().string());
  }
}

std::vector<std::string> sorted(std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  return names;
}

/// Folders of scenarios, one for each task.
std::vector<fs::path> task_folders() {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(root(), ignored)) {
    const fs::path name = entry.path().filename();
    const bool is_task = name != kModels && name != kReferences;
    if (is_task && entry.is_directory(ignored)) folders.push_back(entry.path());
  }
  return folders;
}

/// The file called `name` in the subfolder `part` of any task's folder.
std::optional<fs::path> find_of_task(const std::string& name, const fs::path& part,
                                     const std::string& extension) {
  for (const fs::path& folder : task_folders()) {
    if (auto file = existing(name, folder / part / (name + extension))) return file;
  }
  return std::nullopt;
}

std::vector<std::string> names_of_tasks(const fs::path& part, const std::string& extension) {
  std::vector<std::string> names;
  for (const fs::path& folder : task_folders()) add_names(folder / part, extension, names);
  return sorted(std::move(names));
}

fs::path model_file(const std::string& name) { return fs::path(kModels) / name / (name + ".urdf"); }

}  // namespace

std::optional<fs::path> find_shipped_scenario(const std::string& name) {
  return find_of_task(name, "", ".yaml");
}

std::vector<std::string> shipped_scenarios() { return names_of_tasks("", ".yaml"); }

std::optional<fs::path> find_shipped_policy(const std::string& name) {
  return find_of_task(name, "policies", ".h5");
}

std::vector<std::string> shipped_policies() { return names_of_tasks("policies", ".h5"); }

std::optional<fs::path> find_shipped_reference(const std::string& name) {
  return existing(name, root() / kReferences / (name + ".yaml"));
}

std::vector<std::string> shipped_references() {
  std::vector<std::string> names;
  add_names(root() / kReferences, ".yaml", names);
  return sorted(std::move(names));
}

std::optional<fs::path> find_shipped_model(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  const std::string& model = name == model_file(stem) ? stem : name;
  return existing(model, root() / model_file(model));
}

std::vector<std::string> shipped_models() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(root() / kModels, ignored)) {
    const std::string name = entry.path().filename().string();
    if (find_shipped_model(name)) names.push_back(name);
  }
  return sorted(std::move(names));
}

}  // namespace skybody
