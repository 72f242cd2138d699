// A table of velocities over time, from a CSV file.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace skybody {

/// Rows of time and velocity, at least two, with increasing times.
struct VelocityTable {
  static constexpr int kColumns = 4;                   ///< t [s], x, y, z [m/s]
  static constexpr std::size_t kMostBytes = 16 << 20;  ///< largest file size
  static constexpr double kFastest = 100.0;            ///< largest magnitude of each component
                                                       ///< [m/s]

  std::vector<double> values;  ///< row after row

  std::size_t rows() const { return values.size() / kColumns; }
  double time(std::size_t row) const { return values[row * kColumns]; }
  double begin() const { return time(0); }
  double end() const { return time(rows() - 1); }
  /// Whether all steps are equal: each time is within a billionth of a step of its place on a
  /// uniform grid.
  bool has_equal_steps() const;
};

/// Reads a file: `t,x,y,z` in the first line that is neither empty nor a comment (#), then rows of
/// four numbers.
/// @throws std::runtime_error with FILE:LINE and the remedy; quoted cells are not supported
VelocityTable read_velocity_table(const std::string& file);

}  // namespace skybody
