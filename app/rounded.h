// Numbers in messages and tables.
#pragma once

#include <cstdio>
#include <string>

namespace skybody {

/// To four digits: what is computed has more than anybody reads.
inline std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace skybody
