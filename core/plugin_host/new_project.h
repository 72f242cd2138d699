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

/// Files of a project that are written from the same templates.
struct ProjectPart {
  std::string name;                    ///< replaces @NAME@, and NAME in names of files
  std::vector<std::string> templates;  ///< folders below plugins/template
  ProjectWords words;
  std::filesystem::path folder = {};  ///< in the project; empty: the project's own
};

/// Writes the folder `target_dir`/`name` from the templates of its parts. All or nothing: either
/// the complete folder appears, or none.
/// @returns the new folder
/// @throws Error if the folder exists, or if it cannot be written
std::filesystem::path write_new_project(const std::vector<ProjectPart>& parts,
                                        const std::string& name,
                                        const std::filesystem::path& target_dir);

/// The part with a plugin: CMakeLists.txt, NAME.cpp with a small working plugin of that kind, a
/// test, a scenario that uses it and a README with the commands.
/// @throws Error if the name is not lower_snake_case or is the name of a shipped plugin or test
///         target
ProjectPart plugin_part(SkybodyKind kind, const std::string& name);

/// Writes the folder `target_dir`/`name` with that part alone.
/// @returns the new folder
/// @throws Error as plugin_part() and write_new_project()
std::filesystem::path write_new_plugin_project(SkybodyKind kind, const std::string& name,
                                               const std::filesystem::path& target_dir);

}  // namespace skybody
