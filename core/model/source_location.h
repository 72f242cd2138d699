// The location of a value in the user's input, for messages. C++17.
#pragma once

#include <string>

namespace skybody {

/// The location of a value: file and position, or "--set path=value" with line 0.
struct SourceLocation {
  std::string file;
  int line = 0;    ///< from 1; 0: not from a file
  int column = 0;  ///< from 1
};

}  // namespace skybody
