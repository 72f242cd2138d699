// A CSV file of numbers over time, for plugins with a parameter `file`.
#pragma once

#include <string>
#include <vector>

namespace skybody::reference {

/// The columns of a file. The first is the time [s].
struct TimedColumns {
  std::vector<const char*> names;
  std::size_t least = 0;  ///< number of columns that every file has; the others may be left out
  double greatest = 0.0;  ///< magnitude of a number, except times
  const char* unit = "";  ///< of these numbers, for messages, such as " m/s"
};

/// Numbers row after row. Times rise.
struct TimedTable {
  std::size_t columns = 0;
  std::vector<double> values;
  std::vector<std::string> places;  ///< FILE:LINE of each row, for messages

  std::size_t rows() const { return places.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
  double time(std::size_t row) const { return at(row, 0); }
};

/// Throws the error of a file. @throws std::runtime_error
[[noreturn]] void refuse_file(const std::string& place, const std::string& why);

/// Reads a regular file of up to 16 MiB: a line of names, then two rows of numbers or more.
/// @throws std::runtime_error with file and line
TimedTable read_timed_table(const std::string& file, const TimedColumns& columns);

}  // namespace skybody::reference
