#include "core/io/shipped_files.h"

#include <dlfcn.h>

namespace skybody {
namespace {

namespace fs = std::filesystem;

/// Any address inside libskybody.
const char kAnchor = 0;

/// The folder that libskybody.so lies in.
fs::path library_folder() {
  Dl_info info;
  if (dladdr(&kAnchor, &info) == 0 || info.dli_fname == nullptr) return {};
  std::error_code ignored;
  return fs::weakly_canonical(info.dli_fname, ignored).parent_path();
}

bool is_word(const std::string& name) {
  return !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

std::optional<fs::path> existing(const fs::path& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored)) return path;
  return std::nullopt;
}

}  // namespace

std::optional<fs::path> find_shipped(const std::string& relative) {
  if (auto installed = existing(library_folder().parent_path() / "share/skybody" / relative)) {
    return installed;
  }
  for (const char* folder : {"", "plugins", "scripts"}) {  // template and scripts lie deeper here
    if (auto source = existing(fs::path(SKYBODY_SOURCE_TREE) / folder / relative)) return source;
  }
  return std::nullopt;
}

std::optional<fs::path> find_shipped_scenario(const std::string& name) {
  return is_word(name) ? find_shipped("scenarios/" + name + ".yaml") : std::nullopt;
}

std::optional<fs::path> find_shipped_model(const std::string& name) {
  return is_word(name) ? find_shipped("scenarios/models/" + name + "/" + name + ".urdf") : std::nullopt;
}

}  // namespace skybody
