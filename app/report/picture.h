// Pictures of a flight, drawn by the Python module skybody.plot in a separate Python process.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skybody {

/// The result of draw_pictures().
struct Pictures {
  std::vector<std::filesystem::path> files;
  std::string failure;  ///< reason why some or all are missing; empty: success
};

/// Draws `log` into its folder. The interpreter is $SKYBODY_PYTHON, otherwise the one chosen when
/// Skybody was configured, otherwise python3 on PATH. It is started directly, never through a
/// shell.
Pictures draw_pictures(const std::filesystem::path& log);

}  // namespace skybody
