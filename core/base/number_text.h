// Numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace skybody {

/// A number as users write it: 0.5, 1.9533e-06. std::to_string would turn the latter into 0.
inline std::string to_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%g", value);
  return buffer;
}

}  // namespace skybody
