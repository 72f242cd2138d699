// Files that Python programs make from a flight log: pictures, a page for a browser.
#pragma once

#include <filesystem>

#include "app/python_tool.h"

namespace skybody {

/// Draws `log` into its folder (skybody.plot).
MadeFiles draw_pictures(const std::filesystem::path& log);

/// Writes a page that plays `log` into its folder (skybody.view).
MadeFiles write_view(const std::filesystem::path& log);

}  // namespace skybody
