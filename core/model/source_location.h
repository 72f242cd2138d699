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

/// `file:line:column`, without the parts that are 0.
inline std::string to_string(const SourceLocation& mark) {
  std::string text = mark.file;
  if (mark.line > 0) text += ':' + std::to_string(mark.line);
  if (mark.line > 0 && mark.column > 0) text += ':' + std::to_string(mark.column);
  return text;
}

}  // namespace skybody
