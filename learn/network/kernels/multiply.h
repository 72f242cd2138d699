// Matrix products built from one tile: some rows by some vectors of columns, whose sums stay in
// registers over the inner index. A layer, its gradient at the inputs and its gradient at the
// weights use this tile with different strides. Every sum runs over the inner index in order, so
// that neither the tile's shape nor the division of loops changes the bits.
#pragma once

#include "learn/network/kernels/finish.h"
#include "learn/network/kernels/floats.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

/// Block size of the inner index: this part of a panel of weights (24 KiB) stays in the L1 cache
/// while rows pass.
inline constexpr int kInnerBlock = 96;

/// Addresses of a tile's factors and sums.
struct Tile {
  const float* x;  ///< row r and inner index k at x + r * x_row + k * x_inner
  ptrdiff_t x_row, x_inner;
  int inner;
  const float* weight;  ///< inner index k at weight + k * weight_stride
  ptrdiff_t weight_stride;
  const float* start;  ///< row r at start + r * start_stride
  ptrdiff_t start_stride;
  float* y;  ///< row r at y + r * y_stride
  ptrdiff_t y_stride;
};

/// StateLayout of `x`: contiguous in a row, or contiguous in an inner index.
enum class Order { kRows, kColumns };

template <Order kOrder, int kRows, int kVectors>
SKYBODY_KERNEL void multiply_tile(const Tile& tile) {
  Floats sum[kRows][kVectors];
  const float* row[kRows];
#pragma GCC unroll 16
  for (int r = 0; r < kRows; ++r) {
    row[r] = tile.x + (kOrder == Order::kRows ? r * tile.x_row : r);
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      sum[r][v] = load(tile.start + r * tile.start_stride + v * kLanes);
    }
  }
  const float* weights = tile.weight;
  for (ptrdiff_t k = 0; k < tile.inner; ++k) {
    Floats weight[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) weight[v] = load(weights + v * kLanes);
#pragma GCC unroll 16
    for (int r = 0; r < kRows; ++r) {
      const Floats x = floats(kOrder == Order::kRows ? row[r][k] : row[0][r]);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum[r][v] = fma(x, weight[v], sum[r][v]);
    }
    weights += tile.weight_stride;
    if (kOrder == Order::kColumns) row[0] += tile.x_inner;
  }
#pragma GCC unroll 16
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) store(tile.y + r * tile.y_stride + v * kLanes, sum[r][v]);
  }
}

/// The last rows, fewer than in a full tile.
template <Order kOrder, int kRows, int kVectors>
SKYBODY_KERNEL void multiply_rest(const Tile& tile, int rows) {
  if constexpr (kRows > 0) {
    if (rows == kRows) {
      multiply_tile<kOrder, kRows, kVectors>(tile);
    } else {
      multiply_rest<kOrder, kRows - 1, kVectors>(tile, rows);
    }
  }
}

/// Processes all rows of the columns of a tile, one tile after another.
/// @param finish  called with (first row, rows) after each tile
template <Order kOrder, int kVectors, class Done>
SKYBODY_KERNEL void multiply_rows(Tile tile, int rows, const Done& done) {
  // Narrow tiles have more rows: enough sums to hide a multiply-add's latency.
  constexpr int kRows = kTileRows * (kTileVectors / kVectors > 1 ? 2 : 1);
  const ptrdiff_t x_step = kOrder == Order::kRows ? kRows * tile.x_row : kRows;
  int r = 0;
  for (; r + kRows <= rows; r += kRows) {
    multiply_tile<kOrder, kRows, kVectors>(tile);
    done(r, kRows);
    tile.x += x_step;
    tile.start += kRows * tile.start_stride;
    tile.y += kRows * tile.y_stride;
  }
  if (r < rows) {
    multiply_rest<kOrder, kRows - 1, kVectors>(tile, rows - r);
    done(r, rows - r);
  }
}

/// The same for any number of vectors up to that of a full tile.
template <Order kOrder, int kVectors = kTileVectors, class Done>
SKYBODY_KERNEL void multiply_vectors(const Tile& tile, int rows, int vectors, const Done& done) {
  if (vectors == kVectors) {
    multiply_rows<kOrder, kVectors>(tile, rows, done);
  } else if constexpr (kVectors > 1) {
    multiply_vectors<kOrder, kVectors - 1>(tile, rows, vectors, done);
  }
}

inline int least(int a, int b) { return a < b ? a : b; }

inline void multiply(const MultiplyCall& call) {
  static const float kZeros[kPanel] = {};
  for (int column = 0; column < call.columns; column += kPanel) {
    const int width = least(kPanel, call.columns - column);
    const float* panel = call.weight + static_cast<ptrdiff_t>(column) * call.inner;
    for (int k = 0; k < call.inner; k += kInnerBlock) {
      const int inner = least(kInnerBlock, call.inner - k);
      const bool is_last = k + inner == call.inner;
      for (int part = 0; part < width; part += kTileVectors * kLanes) {
        const int vectors = least(kTileVectors, (width - part) / kLanes);
        float* y = call.y + column + part;
        Tile tile = {call.x + k, call.x_stride, 1, inner, panel + k * width + part, width, y, 0,
                     y,          call.y_stride};
        tile.start_stride = call.y_stride;
        if (k == 0) {
          tile.start = call.start != nullptr ? call.start + column + part : kZeros;
          tile.start_stride = call.start != nullptr ? call.start_stride : 0;
        }
        const auto done = [&](int row, int rows) {
          if (is_last) finish_tile(call, row, rows, column + part, vectors);
        };
        multiply_vectors<Order::kRows>(tile, call.rows, vectors, done);
      }
    }
  }
}

/// sum += the rows of d.
inline void add_rows(const OuterCall& call) {
  for (int column = 0; column < call.columns; column += kLanes) {
    Floats sum = load(call.bias + column);
    for (ptrdiff_t r = 0; r < call.rows; ++r) sum = sum + load(call.d + r * call.d_stride + column);
    store(call.bias + column, sum);
  }
}

inline void outer(const OuterCall& call) {
  for (int column = 0; column < call.columns; column += kPanel) {
    const int width = least(kPanel, call.columns - column);
    float* panel = call.gradient + static_cast<ptrdiff_t>(column) * call.inner;
    for (ptrdiff_t r = 0; r < call.rows; r += kInnerBlock) {
      const int rows = least(kInnerBlock, call.rows - static_cast<int>(r));
      for (int part = 0; part < width; part += kTileVectors * kLanes) {
        const int vectors = least(kTileVectors, (width - part) / kLanes);
        const Tile tile = {call.x + r * call.x_stride,
                           1,
                           call.x_stride,
                           rows,
                           call.d + r * call.d_stride + column + part,
                           call.d_stride,
                           panel + part,
                           width,
                           panel + part,
                           width};
        multiply_vectors<Order::kColumns>(tile, call.inner, vectors, [](int, int) {});
      }
    }
  }
  add_rows(call);
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
