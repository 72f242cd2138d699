// All plugins on a search path.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/parameter_spec.h"
#include "core/model/refused_files.h"  // IWYU pragma: export
#include "core/plugin_abi/abi.h"
#include "core/plugin_host/library.h"
#include "core/plugin_host/plugin_manifest.h"
#include "core/plugin_host/search_path.h"  // IWYU pragma: export

namespace skybody {

/// A plugin, or a file that should contain one.
struct PluginEntry {
  SkybodyKind kind = SKYBODY_KIND_COUNT;  ///< SKYBODY_KIND_COUNT: unknown, the file is unusable
  std::string name;  ///< of the plugin; for an unusable file the name that it promises
  std::string version;
  std::string doc;  ///< one line
  std::filesystem::path file;
  bool vectorized = false;  ///< serves several environments at once
  std::vector<ParameterSpec> parameters;
  std::string failure;          ///< reason why it cannot be used; empty: it can
  bool is_not_trusted = false;  ///< the reason is that other users could replace the file
  const SkybodyPlugin* descriptor = nullptr;
  std::shared_ptr<PluginLibrary> library;
};

/// The libraries in the folders of a search path. File names are listed at once. A library is
/// opened once, when find() requests a plugin that it promises (see PluginManifest). A library that
/// other users may write (see trust_problem) is not opened. Shipped libraries are exempt if others
/// may write libskybody too, since Skybody itself is then under their control. Thread-safe.
class PluginRegistry {
 public:
  /// Folders in order of the path, files sorted by name; missing folders are skipped. A file that
  /// cannot be used does not stop the others: it becomes an entry with a `failure`, as does a
  /// folder whose names cannot be read. A file that is found twice counts once. Two files with the
  /// same plugin (kind and name) make both unusable.
  explicit PluginRegistry(const std::vector<std::filesystem::path>& search_path,
                          RefusedFiles refused = {});

  /// The plugin of that kind and name, or an unusable file that promises the name, or null. Opens
  /// the files that promise the name. Check `failure` before use. The entry lives as long as the
  /// registry.
  const PluginEntry* find(SkybodyKind kind, std::string_view name) const;
  /// Names of known() plugins of a kind, sorted.
  std::vector<std::string> names(SkybodyKind kind) const;
  /// Names promised by libraries that are not open, sorted. Their kinds are not known yet.
  std::vector<std::string> promised() const;
  /// Usable plugins of a kind, sorted by name, of all open libraries and of all shipped ones. Runs
  /// no other code.
  std::vector<const PluginEntry*> known(SkybodyKind kind) const;
  /// Opens every library. Returns all entries in the order of the search.
  std::vector<const PluginEntry*> open_all() const;
  const std::vector<std::filesystem::path>& search_path() const { return search_path_; }

 private:
  struct File {
    std::filesystem::path path;         ///< canonical
    std::vector<PluginManifest> found;  ///< under this name, and as links to it
    bool shipped = false;
    bool open = false;
    std::vector<PluginEntry> entries;  ///< immutable once the file is open
    bool promises(std::string_view name) const;
  };

  static std::vector<PluginEntry> compare(const File& file, std::vector<PluginEntry> held);
  void add_folder(const std::filesystem::path& folder);
  void add_unreadable(const std::filesystem::path& folder, const std::string& problem);
  void check_trust(const File& file) const;
  std::shared_ptr<PluginLibrary> load(const File& file) const;
  void open(File& file) const;

  std::vector<std::filesystem::path> search_path_;
  RefusedFiles refused_;
  mutable std::mutex mutex_;  ///< guards the members of a File that opening it sets
  mutable std::vector<File> files_;
};

}  // namespace skybody
