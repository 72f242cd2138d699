#include "core/io/yaml/include_chain.h"

#include <algorithm>
#include <filesystem>

#include "core/io/files/file.h"
#include "core/io/files/shipped_files.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// The files named by a file's own `include`, those that override others first.
std::vector<std::string> directly_included(const std::string& file, InputBudget& budget) {
  Diagnostics ignored;
  const std::optional<std::string> text = read_file(file, {}, ignored);
  if (!text || !budget.take_file(text->size())) return {};
  const std::optional<ConfigNode> root = parse_yaml(*text, file, ignored, budget);
  const ConfigNode* include = root ? root->find("include") : nullptr;
  if (include == nullptr) return {};
  std::vector<std::string> files;
  if (include->is_scalar()) files.push_back(included_path(*include));
  for (const ConfigNode& item : include->items) {
    if (item.is_scalar()) files.push_back(included_path(item));
  }
  std::reverse(files.begin(), files.end());
  return files;
}

std::string presets_beside(const std::string& file) {
  const fs::path path = file;
  return (path.parent_path() / "training" / (path.stem().string() + ".yaml")).string();
}

}  // namespace

std::string included_path(const ConfigNode& name) {
  std::string path = resolve_path(name.scalar, name.mark);
  std::error_code ignored;
  const bool is_folder = fs::is_directory(path, ignored);
  if (fs::exists(path, ignored) && !is_folder) return path;
  const fs::path wanted = name.scalar;
  if (wanted.has_parent_path() || (wanted.has_extension() && wanted.extension() != ".yaml")) {
    return path;
  }
  const auto shipped = find_shipped_scenario(wanted.stem().string());
  return shipped ? shipped->string() : path;
}

std::vector<std::string> included_files(const std::string& file) {
  InputBudget budget;
  std::vector<std::string> files = {file};
  for (std::size_t next = 0; next < files.size(); ++next) {
    for (std::string& found : directly_included(files[next], budget)) {
      const bool is_known = std::find(files.begin(), files.end(), found) != files.end();
      if (!is_known && budget.take_include()) files.push_back(std::move(found));
    }
  }
  files.erase(files.begin());
  return files;
}

std::string training_presets(const std::string& file) {
  const std::string own = presets_beside(file);
  if (is_file(own)) return own;
  for (const std::string& included : included_files(file)) {
    std::string presets = presets_beside(included);
    if (is_file(presets)) return presets;
  }
  return own;
}

}  // namespace skybody
