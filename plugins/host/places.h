// Where plugins are looked for.
#pragma once

#include <filesystem>
#include <vector>

namespace skybody {

/// The folder of shipped plugins: skybody/plugins beside libskybody.so.
std::filesystem::path shipped_plugin_folder();

/// Where plugins are looked for: entries of SKYBODY_PLUGIN_PATH (colon-separated, empty ones
/// ignored), the scenario's folder and its subfolder `plugins` (unless `scenario_folder` is empty),
/// the shipped plugins.
std::vector<std::filesystem::path> default_search_path(
    const std::filesystem::path& scenario_folder);

}  // namespace skybody
