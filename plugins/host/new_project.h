// `skybody new`: a plugin project to start from.
#pragma once

#include <filesystem>
#include <string>

#include "plugins/api/abi.h"

namespace skybody {

/// Writes the folder `target_dir`/`name`: CMakeLists.txt, NAME.cpp with a small working plugin of
/// that kind, a test, a scenario that flies it and a README with the commands. All or nothing: the
/// folder appears complete, or not at all.
/// @returns the new folder
/// @throws Error if the name is not lower_snake_case or is the name of a shipped plugin or test
///         target, if the folder exists, or if it cannot be written
std::filesystem::path write_new_plugin_project(SkybodyKind kind, const std::string& name,
                                               const std::filesystem::path& target_dir);

}  // namespace skybody
