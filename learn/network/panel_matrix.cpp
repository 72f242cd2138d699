#include "learn/network/panel_matrix.h"

#include <algorithm>

namespace skybody::learn {

void transpose(const PanelMatrix& matrix, const float* from, float* to) {
  const PanelMatrix turned = matrix.transposed();
  // Each row of a panel of `turned` comes from a column of a panel of `matrix`.
  for (int first = 0; first < turned.columns; first += kPanel) {
    const int width = std::min(kPanel, turned.columns - first);
    for (int o = 0; o < turned.rows; ++o) {
      const std::size_t step = matrix.at(1, o) - matrix.at(0, o);
      const float* column = from + matrix.at(first, o);
      float* row = to + turned.at(o, first);
      for (int i = 0; i < width; ++i) row[i] = column[static_cast<std::size_t>(i) * step];
    }
  }
}

}  // namespace skybody::learn
