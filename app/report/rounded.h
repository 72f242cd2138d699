// Numbers in messages and tables.
#pragma once

#include <cstdio>
#include <string>

namespace skybody {

/// Rounds to four significant digits for display.
inline std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace skybody
