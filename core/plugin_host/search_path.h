// Folders that are searched for plugins.
#pragma once

#include <filesystem>
#include <vector>

namespace skybody {

/// The folder of shipped plugins: skybody/plugins beside libskybody.so.
std::filesystem::path shipped_plugin_folder();

/// Entries of SKYBODY_PLUGIN_PATH: colon-separated, empty ones ignored.
std::vector<std::filesystem::path> environment_search_path();

/// The default search path: environment_search_path(), then the shipped plugins.
std::vector<std::filesystem::path> default_search_path();

/// The folder of a scenario file and its subfolder `plugins`, absolute. Searched on request only,
/// because the author of the scenario may have put a library there.
std::vector<std::filesystem::path> scenario_plugin_folders(const std::filesystem::path& scenario);

}  // namespace skybody
