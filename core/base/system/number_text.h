// Text of numbers, for messages.
#pragma once

#include <charconv>
#include <cstdio>
#include <string>

namespace skybody {

/// A short form, such as 0.5 or 1.9533e-06. std::to_string would turn the latter into 0.
inline std::string to_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%g", value);
  return buffer;
}

/// The shortest text that parses to the same double.
inline std::string exact_text(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

}  // namespace skybody
