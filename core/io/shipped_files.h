// Where the files that come with Skybody are: in the source tree for a build tree, else in the
// install prefix.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace skybody {

/// A shipped file or folder, such as "scenarios/hover.yaml", "template/task" or "plot_flight.py".
/// Looked for under share/skybody beside the lib folder of libskybody, then in the source tree that
/// this library was built from. Nothing if it is in neither.
std::optional<std::filesystem::path> find_shipped(const std::string& relative);

/// The shipped scenario called `name` (hover -> scenarios/hover.yaml), for what is not itself a file.
std::optional<std::filesystem::path> find_shipped_scenario(const std::string& name);

/// The shipped model called `name` (crazyflie -> scenarios/models/crazyflie/crazyflie.urdf).
std::optional<std::filesystem::path> find_shipped_model(const std::string& name);

}  // namespace skybody
