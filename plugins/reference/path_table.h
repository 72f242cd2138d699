// A path from a CSV file.
#pragma once

#include <string>

#include "plugins/reference/spline.h"

namespace skybody::reference {

/// A path, and whether its table has a yaw column.
struct PathTable {
  Spline spline;
  bool has_yaw = false;
};

/// Reads a table with the columns t [s], x, y, z [m] (W), and optionally yaw [rad], which may cover
/// any number of turns. The path is the minimum-snap spline through its rows, with free ends.
/// @throws std::runtime_error with file and line
PathTable read_path_table(const std::string& file);

}  // namespace skybody::reference
