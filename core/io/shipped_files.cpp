#include "core/io/shipped_files.h"

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

}  // namespace

std::optional<fs::path> find_shipped_scenario(const std::string& name) {
  return find(name, name + ".yaml");
}

std::optional<fs::path> find_shipped_model(const std::string& name) {
  return find(name, "models/" + name + "/" + name + ".urdf");
}

}  // namespace skybody
