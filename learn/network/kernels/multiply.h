// Matrix products built from one tile: some rows by some vectors of columns, whose sums stay in
// registers over the inner index. A layer, a convolution, their gradients at the inputs and at the
// weights use this tile with different strides. Every sum runs over the inner index in order, so
// that neither the tile's shape nor the division of loops changes the bits.
#pragma once

#include "learn/network/kernels/epilogue.h"
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
  const int32_t* offsets = nullptr;  ///< of windows
  int lines = 1;                     ///< of windows, `inner` values each
  ptrdiff_t line_step = 0;
};

/// Layout of `x`: contiguous in a row, or contiguous in an inner index. With windows, rows or inner
/// indices begin at offsets.
enum class Order { kRows, kColumns, kWindowRows, kWindowColumns };

template <Order kOrder>
inline constexpr bool kHasRows = kOrder == Order::kRows || kOrder == Order::kWindowRows;

/// Moves a tile on by some rows.
template <Order kOrder>
SKYBODY_KERNEL void advance(Tile& tile, int rows) {
  if constexpr (kOrder == Order::kRows) {
    tile.x += rows * tile.x_row;
  } else if constexpr (kOrder == Order::kWindowRows) {
    tile.offsets += rows;
  } else {
    tile.x += rows;
  }
  tile.start += rows * tile.start_stride;
  tile.y += rows * tile.y_stride;
}

/// Adds to the sums the products of `inner` consecutive inner indices.
/// @param row  of each row, and updated; ordered by columns, row[0] alone
template <Order kOrder, int kRows, int kVectors>
SKYBODY_KERNEL void multiply_line(const Tile& tile, const float* (&row)[kRows],
                                  const float*& weights, Floats (&sum)[kRows][kVectors]) {
  for (ptrdiff_t k = 0; k < tile.inner; ++k) {
    Floats weight[kVectors];
    if constexpr (kOrder == Order::kWindowColumns) row[0] = tile.x + tile.offsets[k];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) weight[v] = load(weights + v * kLanes);
#pragma GCC unroll 16
    for (int r = 0; r < kRows; ++r) {
      const Floats x = floats(kHasRows<kOrder> ? row[r][k] : row[0][r]);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum[r][v] = fma(x, weight[v], sum[r][v]);
    }
    weights += tile.weight_stride;
    if constexpr (kOrder == Order::kColumns) row[0] += tile.x_inner;
  }
}

template <Order kOrder, int kRows, int kVectors>
SKYBODY_KERNEL void multiply_tile(const Tile& tile) {
  Floats sum[kRows][kVectors];
  const float* row[kRows];
#pragma GCC unroll 16
  for (int r = 0; r < kRows; ++r) {
    row[r] = tile.x + (kOrder == Order::kRows ? r * tile.x_row : r);
    if constexpr (kOrder == Order::kWindowRows) row[r] = tile.x + tile.offsets[r];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      sum[r][v] = load(tile.start + r * tile.start_stride + v * kLanes);
    }
  }
  const float* weights = tile.weight;
  if constexpr (kOrder == Order::kWindowRows) {
    for (int line = 0; line < tile.lines; ++line) {
      multiply_line<kOrder, kRows, kVectors>(tile, row, weights, sum);
#pragma GCC unroll 16
      for (int r = 0; r < kRows; ++r) row[r] += tile.line_step;
    }
  } else {
    multiply_line<kOrder, kRows, kVectors>(tile, row, weights, sum);
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
/// @param done  called with (first row, rows) after each tile
template <Order kOrder, int kVectors, class Done>
SKYBODY_KERNEL void multiply_rows(Tile tile, int rows, const Done& done) {
  // Narrow tiles have more rows: enough sums to hide a multiply-add's latency.
  constexpr int kRows = kTileRows * (kTileVectors / kVectors > 1 ? 2 : 1);
  int r = 0;
  for (; r + kRows <= rows; r += kRows) {
    multiply_tile<kOrder, kRows, kVectors>(tile);
    done(r, kRows);
    advance<kOrder>(tile, kRows);
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

/// Inner indices of the next block: with windows whole lines, at least one.
template <Order kOrder>
SKYBODY_KERNEL int inner_block(const MultiplyCall& call, int first) {
  if constexpr (kOrder == Order::kWindowRows) {
    const int lines = kInnerBlock / call.windows.line;
    return least((lines > 1 ? lines : 1) * call.windows.line, call.inner - first);
  } else {
    return least(kInnerBlock, call.inner - first);
  }
}

/// The tile of `width` columns, from `column` on, and of `inner` inner indices, from `first` on.
template <Order kOrder>
SKYBODY_KERNEL Tile tile_of(const MultiplyCall& call, int first, int inner, const float* panel,
                            int width, int column) {
  static const float kZeros[kPanel] = {};
  float* y = call.y + column;
  const float* weight = panel + first * width + column % kPanel;
  Tile tile = {call.x + first, call.x_stride, 1, inner, weight, width, y, call.y_stride, y,
               call.y_stride};
  if (first == 0) {
    tile.start = call.start != nullptr ? call.start + column : kZeros;
    tile.start_stride = call.start != nullptr ? call.start_stride : 0;
  }
  if constexpr (kOrder == Order::kWindowRows) {
    const Windows& windows = call.windows;
    tile.x = call.x + first / windows.line * static_cast<ptrdiff_t>(windows.line_step);
    tile.inner = windows.line;
    tile.offsets = windows.offsets;
    tile.lines = inner / windows.line;
    tile.line_step = windows.line_step;
  }
  return tile;
}

template <Order kOrder>
inline void multiply_by_panels(const MultiplyCall& call) {
  for (int column = 0; column < call.columns; column += kPanel) {
    const int width = least(kPanel, call.columns - column);
    const float* panel = call.weight + static_cast<ptrdiff_t>(column) * call.inner;
    for (int k = 0; k < call.inner;) {
      const int inner = inner_block<kOrder>(call, k);
      const bool is_last = k + inner == call.inner;
      for (int part = 0; part < width; part += kTileVectors * kLanes) {
        const int vectors = least(kTileVectors, (width - part) / kLanes);
        const Tile tile = tile_of<kOrder>(call, k, inner, panel, width, column + part);
        const auto done = [&](int row, int rows) {
          if (is_last) apply_epilogue(call, row, rows, column + part, vectors);
        };
        multiply_vectors<kOrder>(tile, call.rows, vectors, done);
      }
      k += inner;
    }
  }
}

inline void multiply(const MultiplyCall& call) {
  if (call.windows.offsets != nullptr) {
    multiply_by_panels<Order::kWindowRows>(call);
  } else {
    multiply_by_panels<Order::kRows>(call);
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

/// The product of x's columns `first` ... first + inner - 1, which are consecutive in memory, with
/// the rows of d, block by block.
template <Order kOrder>
inline void outer_of(const OuterCall& call, const float* x, int first, int inner) {
  for (int column = 0; column < call.columns; column += kPanel) {
    const int width = least(kPanel, call.columns - column);
    float* panel = call.gradient + static_cast<ptrdiff_t>(column) * call.inner +
                   static_cast<ptrdiff_t>(first) * width;
    for (ptrdiff_t r = 0; r < call.rows; r += kInnerBlock) {
      const int rows = least(kInnerBlock, call.rows - static_cast<int>(r));
      for (int part = 0; part < width; part += kTileVectors * kLanes) {
        const int vectors = least(kTileVectors, (width - part) / kLanes);
        Tile tile = {x + r * call.x_stride,
                     1,
                     call.x_stride,
                     rows,
                     call.d + r * call.d_stride + column + part,
                     call.d_stride,
                     panel + part,
                     width,
                     panel + part,
                     width};
        if constexpr (kOrder == Order::kWindowColumns) {
          tile.x = x;
          tile.offsets = call.windows.offsets + r;
        }
        multiply_vectors<kOrder>(tile, inner, vectors, [](int, int) {});
      }
    }
  }
}

inline void outer(const OuterCall& call) {
  const Windows& windows = call.windows;
  if (windows.offsets == nullptr) {
    outer_of<Order::kColumns>(call, call.x, 0, call.inner);
  } else {
    for (ptrdiff_t line = 0; line < windows.lines; ++line) {
      outer_of<Order::kWindowColumns>(call, call.x + line * windows.line_step,
                                      static_cast<int>(line) * windows.line, windows.line);
    }
  }
  add_rows(call);
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
