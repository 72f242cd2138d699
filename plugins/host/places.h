// Where Skybody's own files lie, in the build tree and in an installation.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skybody {

/// The folder of libskybody.so (or of the program, where it is linked statically).
std::filesystem::path library_folder();

/// The folder of shipped plugins: skybody/plugins beside libskybody.so.
std::filesystem::path shipped_plugin_folder();

/// share/skybody/NAME of the prefix that libskybody.so is installed in, or, in a build tree, the
/// source folder `source_folder` of the same data. Empty if neither exists.
std::filesystem::path shipped_data(const std::string& name, const std::string& source_folder);

/// Where plugins are looked for: entries of SKYBODY_PLUGIN_PATH (colon-separated, empty ones
/// ignored), the scenario's folder and its subfolder `plugins` (unless `scenario_folder` is empty),
/// the shipped plugins.
std::vector<std::filesystem::path> default_search_path(const std::filesystem::path& scenario_folder);

}  // namespace skybody
