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
#include "plugins/api/abi.h"
#include "plugins/host/library.h"
#include "plugins/host/plugin_manifest.h"
#include "plugins/host/search_path.h"  // IWYU pragma: export

namespace skybody {

/// A plugin that was found, or a file that should have been one.
struct PluginEntry {
  SkybodyKind kind = SKYBODY_KIND_COUNT;  ///< SKYBODY_KIND_COUNT: not known, the file is unusable
  std::string name;  ///< the plugin's; of an unusable file, the one that it promises
  std::string version;
  std::string doc;  ///< one line
  std::filesystem::path file;
  bool vectorized = false;  ///< serves several environments at a time
  std::vector<ParameterSpec> parameters;
  std::string failure;          ///< why it cannot be used; empty: it can
  bool is_not_trusted = false;  ///< that is why: others could put such a file there
  const SkybodyPlugin* descriptor = nullptr;
  std::shared_ptr<PluginLibrary> library;
};

/// The libraries in the folders of a search path. It lists file names at once, and opens a library
/// when a plugin is asked for that the library promises (see PluginManifest), once each. A library
/// that others may write (see trust_problem) is not opened. Shipped ones are exempt where others
/// may write libskybody as well: then Skybody itself is theirs. May be used by several threads.
class PluginRegistry {
 public:
  /// Folders in order of the path, files in order of their names; folders that do not exist are
  /// skipped. A file that cannot be used does not stop the others: it becomes an entry with a
  /// `failure`, as does a folder whose names cannot be read. One file that is found twice counts
  /// once; two files with one plugin (kind and name) make both unusable.
  explicit PluginRegistry(const std::vector<std::filesystem::path>& search_path,
                          RefusedFiles refused = {});

  /// The plugin of that kind and name, or a file that promises the name and cannot be used, or
  /// null. Opens the files that promise the name. Check `failure` before use. Lives as long as
  /// this.
  const PluginEntry* find(SkybodyKind kind, std::string_view name) const;
  /// Names of known() plugins of a kind, sorted.
  std::vector<std::string> names(SkybodyKind kind) const;
  /// What libraries promise that are not open, sorted: plugins of kinds that are not known yet.
  std::vector<std::string> promised() const;
  /// Usable plugins of a kind, sorted by name, of the libraries that are open and of all shipped
  /// ones: no other code is run.
  std::vector<const PluginEntry*> known(SkybodyKind kind) const;
  /// Opens every library: all that was found, in the order of the search.
  std::vector<const PluginEntry*> open_all() const;
  const std::vector<std::filesystem::path>& search_path() const { return search_path_; }

 private:
  struct File {
    std::filesystem::path path;         ///< canonical
    std::vector<PluginManifest> found;  ///< under this name, and as links to it
    bool shipped = false;
    bool open = false;
    std::vector<PluginEntry> entries;  ///< does not change once the file is open
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
  mutable std::mutex mutex_;  ///< guards what a File gets when it is opened
  mutable std::vector<File> files_;
};

}  // namespace skybody
