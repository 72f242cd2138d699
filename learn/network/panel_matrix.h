// How a matrix of weights lies in memory: panels of 64 columns, so that a product reads it in one
// stream and a block of it stays in the first cache whatever the layer's width.
#pragma once

#include <cstddef>

#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

/// The next multiple of kPad: floats of a whole cache line.
template <class Int>
constexpr Int padded(Int count) {
  return (count + Int{kPad} - 1) / Int{kPad} * Int{kPad};
}

/// Columns are padded to a multiple of kPad, and cut into panels of kPanel, the last one narrower.
/// Panels lie one after another, each row by row.
struct PanelMatrix {
  int rows = 0, columns = 0;

  int padded_columns() const { return padded(columns); }
  std::size_t size() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(padded_columns());
  }
  PanelMatrix transposed() const { return {columns, rows}; }
  /// Where an element lies.
  std::size_t at(int row, int column) const {
    const int first = column / kPanel * kPanel;
    const int width = padded_columns() - first < kPanel ? padded_columns() - first : kPanel;
    return static_cast<std::size_t>(first) * static_cast<std::size_t>(rows) +
           static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column - first);
  }
};

/// Writes a matrix of this size transposed, as transposed() lays it out. Padding is not written.
void transpose(const PanelMatrix& matrix, const float* from, float* to);

}  // namespace skybody::learn
