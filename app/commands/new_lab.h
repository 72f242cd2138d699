// Creates the repository of a laboratory: vehicle, task, controller, scenario, training and tests.
#pragma once

#include <filesystem>
#include <string>

namespace skybody {

/// Writes the folder `folder`/`name`: the vehicle NAME_quad, the controller NAME_law and the task
/// NAME_task, each as its own `skybody new` writes it, and the files that join them.
/// @returns the new folder
/// @throws Error if the name is not lower_snake_case, if the folder exists, or if it cannot be
///         written
std::filesystem::path write_new_lab(const std::string& name, const std::filesystem::path& folder);

}  // namespace skybody
