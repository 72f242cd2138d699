// Activations and their slopes, applied to the sums of a tile.
#pragma once

#include "learn/network/kernels/functions.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

template <Epilogue kEpilogue>
SKYBODY_KERNEL Floats activated(const Floats& sum, const float* output) {
  const Floats zero = floats(0.0f), one = floats(1.0f);
  if constexpr (kEpilogue == Epilogue::kTanh) {
    return tanh(sum);
  } else if constexpr (kEpilogue == Epilogue::kRelu) {
    return max(zero, sum);  // NaN gives NaN
  } else if constexpr (kEpilogue == Epilogue::kElu) {
    return select(zero < sum, sum, expm1_of_negative(min(zero, sum)));
  } else {
    const Floats y = load(output);
    if constexpr (kEpilogue == Epilogue::kTanhSlope) return sum * fma(zero - y, y, one);
    if constexpr (kEpilogue == Epilogue::kReluSlope) return select(zero < y, sum, zero);
    return select(zero < y, sum, sum * (y + one));
  }
}

template <Epilogue kEpilogue>
inline void apply_to_rows(const MultiplyCall& call, int row, int rows, int column, int vectors) {
  for (ptrdiff_t r = row; r < row + rows; ++r) {
    float* y = call.y + r * call.y_stride + column;
    const float* output = call.output + r * call.output_stride + column;
    for (int v = 0; v < vectors * kLanes; v += kLanes) {
      store(y + v, activated<kEpilogue>(load(y + v), output + v));
    }
  }
}

/// Applies the activation to complete sums: `rows` rows from `row` on, `vectors` vectors from
/// `column` on.
inline void apply_epilogue(const MultiplyCall& call, int row, int rows, int column, int vectors) {
  switch (call.epilogue) {
    case Epilogue::kNone:
      return;
#define SKYBODY_CASE(NAME) \
  case Epilogue::NAME:     \
    return apply_to_rows<Epilogue::NAME>(call, row, rows, column, vectors);
      SKYBODY_CASE(kTanh)
      SKYBODY_CASE(kRelu)
      SKYBODY_CASE(kElu)
      SKYBODY_CASE(kTanhSlope)
      SKYBODY_CASE(kReluSlope)
      SKYBODY_CASE(kEluSlope)
#undef SKYBODY_CASE
  }
}

inline void slope(const SlopeCall& call) {
  MultiplyCall row = {};
  row.columns = kLanes;
  row.y = call.d;
  row.y_stride = kLanes;
  row.epilogue = call.slope;
  row.output = call.output;
  row.output_stride = kLanes;
  apply_epilogue(row, 0, static_cast<int>(call.count / kLanes), 0, 1);
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
