// Files that Python programs make from a flight log: pictures, a page for a browser.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skybody {

/// The result of draw_pictures() or write_view().
struct MadeFiles {
  std::vector<std::filesystem::path> files;
  std::string failure;  ///< reason why some or all are missing; empty: success
};

/// Draws `log` into its folder (skybody.plot). The interpreter is $SKYBODY_PYTHON, otherwise the
/// one chosen when Skybody was configured, otherwise python3 on PATH. It is started directly, never
/// through a shell.
MadeFiles draw_pictures(const std::filesystem::path& log);

/// Writes a page that plays `log` into its folder (skybody.view), by the same interpreter.
MadeFiles write_view(const std::filesystem::path& log);

}  // namespace skybody
