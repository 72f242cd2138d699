// The names of a library's plugins, read without opening the library.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace skybody {

/// A library in a folder. X.so promises the plugin X. If a text file X.plugins (its sidecar) lies
/// beside it, X.so promises the names in that file: one per line, `#` begins a comment.
struct PluginManifest {
  std::filesystem::path file;      ///< as found, symbolic links not followed
  std::filesystem::path sidecar;   ///< empty: there is none
  std::vector<std::string> names;  ///< of plugins
  std::string problem;             ///< reason why the sidecar cannot be used; empty: it can

  bool promises(std::string_view name) const;
};

/// Reason why the names in a folder cannot be read; empty if they can, or if the folder does not
/// exist.
std::string folder_problem(const std::filesystem::path& folder);

/// The *.so files of a folder, sorted by name; none if the folder does not exist or cannot be read.
std::vector<PluginManifest> plugin_manifests(const std::filesystem::path& folder);

}  // namespace skybody
