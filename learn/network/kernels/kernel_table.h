// The hot loops of learning, once for each instruction set. Plain functions and types only: files
// compiled for AVX-512 include this header, so it must not include inline functions of the standard
// library (the linker could choose their AVX-512 copy for every processor).
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/base/simd/isa_sets.h"

namespace skybody::learn {

/// Columns of a panel: a matrix is stored as panels of this many columns, the last one narrower,
/// one after another, each row by row.
inline constexpr int kPanel = 64;
/// Columns are padded with zeros to a multiple of this.
inline constexpr int kPad = 16;

/// Function applied to a sum before it is stored. For slopes, which are a layer's derivatives, the
/// argument is the layer's output.
enum class Epilogue : int { kNone, kTanh, kRelu, kElu, kTanhSlope, kReluSlope, kEluSlope };

/// Rows that are windows of an image, as in a convolution: row r consists of `lines` lines of
/// `line` consecutive floats. They begin at x + offsets[r], `line_step` floats apart.
struct Windows {
  const int32_t* offsets = nullptr;  ///< null: rows are no windows
  int lines = 1, line = 0;           ///< lines * line is `inner` of the call
  int line_step = 0;
};

/// y = epilogue(start + x w): row r of `x` at x + r * x_stride, `inner` wide.
struct MultiplyCall {
  const float* x;
  int x_stride;  ///< not used by windows
  int rows, inner;
  const float* weight;   ///< inner x columns, in panels
  int columns;           ///< a multiple of kPad
  const float* start;    ///< `columns` initial values of the sums; null: zero
  int start_stride = 0;  ///< 0: the same for all rows
  float* y;
  int y_stride;  ///< at least `columns`
  Epilogue epilogue = Epilogue::kNone;
  const float* output = nullptr;  ///< for slopes: row r at output + r * output_stride
  int output_stride = 0;
  Windows windows = {};
};

/// gradient += x^T d, summed over rows in order; bias += the rows of d.
struct OuterCall {
  const float* x;  ///< rows x inner
  int x_stride;    ///< not used by windows
  const float* d;  ///< rows x columns
  int d_stride;
  int rows, inner;
  int columns;      ///< a multiple of kPad
  float* gradient;  ///< inner x columns, in panels
  float* bias;      ///< `columns`
  Windows windows = {};
};

/// d = d * slope, the derivative at a layer's outputs.
struct SlopeCall {
  Epilogue slope;  ///< kNone or a slope
  float* d;
  const float* output;
  size_t count;  ///< a multiple of kPad
};

/// Adds row r of `from` to window r of `x`, rows in order.
struct ScatterCall {
  const float* from;
  int from_stride;
  int rows;
  float* x;
  Windows windows;
};

/// Types of pixels, in the order of ColumnType.
enum class PixelType : int { kFloat32, kUint8, kUint16 };

/// to = (min(max(pixel, low), high) - low) * scale. A pixel that is no number counts as `high`.
struct PixelCall {
  const void* from;
  PixelType type;
  size_t count;
  float low, high, scale;
  float* to;
};

/// A step of gated recurrent units (gru.h): from the sums of both products to the next state. Rows
/// of sums and gates are 3 * units wide: reset, update, candidate.
struct GruCall {
  const float* from_input;
  const float* from_state;
  const float* state;  ///< rows x units, before the step
  float* gates;
  float* next;      ///< rows x units, after the step
  int rows, units;  ///< units: a multiple of kPad
  int sum_stride, state_stride, next_stride;
};

/// Derivatives of such a step, from the derivative at the next state.
struct GruSlopeCall {
  const float* gates;
  const float* from_state;
  const float* state;
  const float* d_next;
  float *d_input, *d_state;  ///< at the sums of both products
  float* d_before;           ///< at the state before the step, direct path only
  int rows, units;
  int sum_stride, state_stride;
  int d_stride;  ///< of d_next and d_before
};

/// The scalars of a step of Adam (adam.h).
struct AdamScalars {
  float gradient_scale;
  float first_rest, second_decay, second_rest;  ///< 1 - beta1, beta2, 1 - beta2
  float rate;                                   ///< learning rate / (1 - beta1^t)
  float second_unbias;                          ///< 1 / sqrt(1 - beta2^t)
  float epsilon;
};

/// The functions for one instruction set. Arrays need no alignment and may have any size.
struct KernelTable {
  void (*multiply)(const MultiplyCall&);
  void (*outer)(const OuterCall&);
  void (*slope)(const SlopeCall&);
  void (*scatter)(const ScatterCall&);
  void (*pixels)(const PixelCall&);
  void (*gru)(const GruCall&);
  void (*gru_slope)(const GruSlopeCall&);
  void (*adam)(const AdamScalars&, const float* gradient, float* first, float* second,
               float* parameters, size_t count);
  /// Sum of squares: in float lanes over 1024 values, then in double, all in a fixed order.
  double (*square_sum)(const float* values, size_t count);
  /// sum += addend
  void (*add)(const float* addend, float* sum, size_t count);
  void (*tanh)(const float* x, float* y, size_t count);
  /// Standard normals from `count` random words each (of 32 bits; `count` a multiple of 16), 2 *
  /// count values: for every 16 words first 16 cosines, then 16 sines.
  void (*normals)(const uint32_t* radius, const uint32_t* angle, float* y, size_t count);
};

#define SKYBODY_ROW(NAME, LANES, TARGET) \
  namespace kernels::NAME {              \
  extern const KernelTable kTable;       \
  }
SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW

}  // namespace skybody::learn
