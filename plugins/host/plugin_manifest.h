// Which plugins a library promises, known without opening it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace skybody {

/// A library in a folder: X.so promises the plugin X, or where a text file X.plugins (its sidecar)
/// lies beside it, the names in that: one a line, `#` begins a comment.
struct PluginManifest {
  std::filesystem::path file;      ///< as found, symbolic links not followed
  std::filesystem::path sidecar;   ///< empty: there is none
  std::vector<std::string> names;  ///< of plugins
  std::string problem;             ///< why the sidecar cannot be used; empty: it can

  bool promises(std::string_view name) const;
};

/// Why the names in a folder cannot be read; empty: they can, or there is no such folder.
std::string folder_problem(const std::filesystem::path& folder);

/// The *.so files of a folder, in order of their names; none if there is no such folder or it
/// cannot be read.
std::vector<PluginManifest> plugin_manifests(const std::filesystem::path& folder);

}  // namespace skybody
