// Memory layout of weights: panels of 64 columns. A product reads such a matrix in one stream, and
// a block of it stays in the L1 cache for any width of the layer.
#pragma once

#include <cstddef>

#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

/// Rounds up to a multiple of kPad, which is a whole cache line of floats.
template <class Int>
constexpr Int padded(Int count) {
  return (count + Int{kPad} - 1) / Int{kPad} * Int{kPad};
}

/// Columns are padded to a multiple of kPad, and divided into panels of kPanel, the last one
/// narrower. Panels lie one after another, each row by row.
struct PanelMatrix {
  int rows = 0, columns = 0;

  int padded_columns() const { return padded(columns); }
  std::size_t size() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(padded_columns());
  }
  PanelMatrix transposed() const { return {columns, rows}; }
  /// Index of an element.
  std::size_t at(int row, int column) const {
    const int first = column / kPanel * kPanel;
    const int width = padded_columns() - first < kPanel ? padded_columns() - first : kPanel;
    return static_cast<std::size_t>(first) * static_cast<std::size_t>(rows) +
           static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column - first);
  }
};

/// Writes the transposed matrix, in the layout of transposed(). Padding is not written.
void transpose(const PanelMatrix& matrix, const float* from, float* to);

}  // namespace skybody::learn
