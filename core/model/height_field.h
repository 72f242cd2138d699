// Uneven ground: heights on a regular grid. C++17.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace skybody {

/// Heights at the corners of adjacent rectangular cells along x and y. The diagonal from the corner
/// of least x and y to the opposite corner divides each cell into two triangles. The volume below
/// the triangles is solid.
class HeightField {
 public:
  /// @param columns, rows  numbers of heights along x and along y, each 2 or more
  /// @param heights  row by row, in ascending order of x and y [m]
  HeightField(int columns, int rows, std::vector<double> heights)
      : columns_(columns),
        rows_(rows),
        heights_(std::move(heights)),
        highest_(*std::max_element(heights_.begin(), heights_.end())) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const std::vector<double>& heights() const { return heights_; }
  double highest() const { return highest_; }

 private:
  int columns_, rows_;
  std::vector<double> heights_;
  double highest_;
};

}  // namespace skybody
