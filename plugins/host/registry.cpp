#include "plugins/host/registry.h"

#include <algorithm>
#include <set>

#include "plugins/host/descriptor.h"
#include "plugins/host/kind.h"

namespace skybody {
namespace {

/// The *.so files of a folder, in order of their names; none if there is no such folder.
std::vector<std::filesystem::path> shared_libraries(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code failed;
  for (std::filesystem::directory_iterator it(folder, failed), end; !failed && it != end;
       it.increment(failed)) {
    std::error_code ignored;
    if (it->path().extension() == ".so" && it->is_regular_file(ignored))
      files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string two_files(const PluginEntry& a, const PluginEntry& b) {
  return "two plugins of kind " + std::string(kind_name(a.kind)) + " are called `" + a.name +
         "`: " + a.file.string() + " and " + b.file.string() + "; remove or rename one";
}

}  // namespace

PluginRegistry::PluginRegistry(const std::vector<std::filesystem::path>& search_path)
    : search_path_(search_path) {
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& folder : search_path_) {
    for (const std::filesystem::path& file : shared_libraries(folder)) {
      std::error_code failed;
      const std::filesystem::path real = std::filesystem::canonical(file, failed);
      if (!failed && seen.insert(real).second) add_file(real);
    }
  }
}

void PluginRegistry::add_file(const std::filesystem::path& file) {
  PluginEntry entry;
  entry.file = file;
  std::shared_ptr<PluginLibrary> library;
  try {
    library = std::make_shared<PluginLibrary>(file);
  } catch (const PluginLoadError& e) {
    entry.name = file.stem().string();
    entry.failure = e.what();
    entries_.push_back(std::move(entry));
    return;
  }
  for (const SkybodyPlugin* plugin : library->plugins()) {
    PluginEntry found = entry;
    found.kind = static_cast<SkybodyKind>(plugin->kind);
    found.name = plugin->name;
    found.version = plugin->version;
    found.doc = plugin->doc;
    found.vectorized = plugin->vectorized != 0;
    found.parameters = parameter_specs(*plugin);
    found.descriptor = plugin;
    found.library = library;
    for (PluginEntry& other : entries_) {
      if (other.kind != found.kind || other.name != found.name) continue;
      if (other.failure.empty()) other.failure = two_files(other, found);
      found.failure = other.failure;
    }
    entries_.push_back(std::move(found));
  }
}

const PluginEntry* PluginRegistry::find(SkybodyKind kind, std::string_view name) const {
  const PluginEntry* unusable = nullptr;
  for (const PluginEntry& entry : entries_) {
    if (entry.name != name) continue;
    if (entry.kind == kind) return &entry;
    if (entry.kind == SKYBODY_KIND_COUNT && unusable == nullptr) unusable = &entry;
  }
  return unusable;
}

std::vector<std::string> PluginRegistry::names(SkybodyKind kind) const {
  std::vector<std::string> found;
  for (const PluginEntry& entry : entries_) {
    if (entry.kind == kind && entry.failure.empty()) found.push_back(entry.name);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace skybody
