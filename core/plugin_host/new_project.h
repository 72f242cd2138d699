// `skybody new`: creates starter projects.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/plugin_abi/abi.h"

namespace skybody {

/// Placeholders of templates, such as @KIND@, and their values.
using ProjectWords = std::vector<std::pair<std::string_view, std::string>>;

/// Writes the folder `target_dir`/`name` from templates, with @NAME@ and `words` replaced. All or
/// nothing: either the complete folder appears, or none.
/// @param templates  folders below plugins/template
/// @returns the new folder
/// @throws Error if the folder exists, or if it cannot be written
std::filesystem::path write_new_project(const std::vector<std::string>& templates,
                                        const ProjectWords& words, const std::string& name,
                                        const std::filesystem::path& target_dir);

/// Writes the folder `target_dir`/`name`: CMakeLists.txt, NAME.cpp with a small working plugin of
/// that kind, a test, a scenario that uses it and a README with the commands.
/// @returns the new folder
/// @throws Error if the name is not lower_snake_case or is the name of a shipped plugin or test
///         target, if the folder exists, or if it cannot be written
std::filesystem::path write_new_plugin_project(SkybodyKind kind, const std::string& name,
                                               const std::filesystem::path& target_dir);

}  // namespace skybody
