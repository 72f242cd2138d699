// Pictures of a flight, drawn by scripts/plot_flight.py in a Python of its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skybody {

/// What came of it.
struct Pictures {
  std::vector<std::filesystem::path> files;
  std::string failure;  ///< why there are none or not all; empty: all is well
};

/// Draws `log` into its folder. The interpreter is $SKYBODY_PYTHON, else the one chosen when
/// Skybody was configured, else python3 on PATH; it is started directly, never through a shell.
Pictures draw_pictures(const std::filesystem::path& log);

}  // namespace skybody
