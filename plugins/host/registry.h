// All plugins on a search path.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/parameter_spec.h"
#include "plugins/api/abi.h"
#include "plugins/host/library.h"
#include "plugins/host/places.h"  // IWYU pragma: export

namespace skybody {

/// A plugin that was found, or a file that should have been one.
struct PluginEntry {
  SkybodyKind kind = SKYBODY_KIND_COUNT;  ///< SKYBODY_KIND_COUNT: not known, the file is unusable
  std::string name;  ///< the plugin's; of an unusable file, its name without .so
  std::string version;
  std::string doc;  ///< one line
  std::filesystem::path file;
  bool vectorized = false;  ///< serves several environments at a time
  std::vector<ParameterSpec> parameters;
  std::string failure;  ///< why it cannot be used; empty: it can
  const SkybodyPlugin* descriptor = nullptr;
  std::shared_ptr<PluginLibrary> library;
};

/// Loads every *.so in the folders of a search path once. Does not change afterwards.
class PluginRegistry {
 public:
  /// Folders in order of the path, files in order of their names; folders that do not exist are
  /// skipped. A file that cannot be used does not stop the others: it becomes an entry with a
  /// `failure`. One file that is found twice counts once; two files with one plugin (kind and name)
  /// make both unusable.
  explicit PluginRegistry(const std::vector<std::filesystem::path>& search_path);

  /// The plugin of that kind and name, or a file called NAME.so that cannot be used, or null.
  /// Check `failure` before use.
  const PluginEntry* find(SkybodyKind kind, std::string_view name) const;
  /// Names of the usable plugins of a kind, sorted.
  std::vector<std::string> names(SkybodyKind kind) const;
  /// Everything that was found, in the order of the search.
  const std::vector<PluginEntry>& entries() const { return entries_; }
  const std::vector<std::filesystem::path>& search_path() const { return search_path_; }

 private:
  void add_file(const std::filesystem::path& file);

  std::vector<std::filesystem::path> search_path_;
  std::vector<PluginEntry> entries_;
};

}  // namespace skybody
