#include "core/env/group_rows.h"

#include <cstring>

#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/base/math_basic.h"
#include "core/base/pack.h"
#include "core/model/layout.h"
#include "core/physics/lane_values.h"

namespace skybody {
namespace {

// Four lanes times four values at a time: what every instruction set can transpose in registers.
using Floats = float __attribute__((vector_size(16)));
using FloatBits = std::int32_t __attribute__((vector_size(16)));
using Doubles = lanes::Reals4;

SKYBODY_INLINE Floats load_floats(const float* p) {
  Floats v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
SKYBODY_INLINE void store_floats(float* p, const Floats& v) { std::memcpy(p, &v, sizeof(v)); }

/// Row i of the result is column i.
SKYBODY_INLINE void transpose(Floats (&v)[4]) {
  const Floats a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
  const Floats b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
  const Floats c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Floats d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

/// Lanes with a value that is not finite: there the difference is a NaN.
SKYBODY_INLINE FloatBits not_finite(const Floats& v) { return (v - v) != Floats{}; }
SKYBODY_INLINE bool any(const FloatBits& bits) {
  std::uint64_t halves[2];
  std::memcpy(halves, &bits, sizeof(bits));
  return (halves[0] | halves[1]) != 0;
}

SKYBODY_INLINE double clipped(float value) {
  const double a = value;
  return a < -1.0 ? -1.0 : (a > 1.0 ? 1.0 : a);
}

SKYBODY_INLINE bool read_clipped(const float* rows, std::ptrdiff_t stride, int count,
                                 double* values) {
  FloatBits bad{};
  const int whole = count & ~3;
  for (int l = 0; l < kGroupLanes; ++l) {
    for (int k = 0; k < whole; k += 4) bad |= not_finite(load_floats(rows + l * stride + k));
    for (int k = whole; k < count; ++k) {
      bad[0] |= rows[l * stride + k] - rows[l * stride + k] == 0.0f ? 0 : -1;
    }
  }
  if (any(bad)) return false;
  for (int first = 0; first < kGroupLanes; first += 4) {
    const float* row = rows + first * stride;
    double* out = values + first;
    for (int k = 0; k < whole; k += 4) {
      Floats v[4];
      for (int i = 0; i < 4; ++i) v[i] = load_floats(row + i * stride + k);
      transpose(v);
      for (int i = 0; i < 4; ++i) {
        const Pack<4> a(__builtin_convertvector(v[i], Doubles));
        store_lanes(out + (k + i) * kGroupLanes, clamp(a, Pack<4>(-1.0), Pack<4>(1.0)));
      }
    }
    for (int k = whole; k < count; ++k) {
      for (int i = 0; i < 4; ++i) out[k * kGroupLanes + i] = clipped(row[i * stride + k]);
    }
  }
  return true;
}

SKYBODY_INLINE void scale(const double* action, int count, const double* low, const double* high,
                          double* command) {
  for (int k = 0; k < count; ++k) {
    for (int half = 0; half < 2; ++half) {
      const int at = k * kGroupLanes + 4 * half;
      const Pack<4> a = load_lanes<Pack<4>>(action + at);
      store_lanes(command + at, low[k] + 0.5 * (a + 1.0) * (high[k] - low[k]));
    }
  }
}

SKYBODY_INLINE bool are_finite(const double* values, int count) {
  Floats sum[2] = {};  // 0 as long as all are
  for (int k = 0; k < count; ++k) {
    for (int half = 0; half < 2; ++half) {
      const Pack<4> v = load_lanes<Pack<4>>(values + k * kGroupLanes + 4 * half);
      const Floats f = __builtin_convertvector(v.v, Floats);
      sum[half] += f - f;
    }
  }
  return !any((sum[0] + sum[1]) != Floats{});
}

/// @returns the lanes as floats; adds what is not 0 where one of them is not finite
SKYBODY_INLINE Floats to_floats(const double* lanes, Floats& faults) {
  const Pack<4> x = load_lanes<Pack<4>>(lanes);
  const Floats f = __builtin_convertvector(x.v, Floats);
  faults += f - f;
  return f;
}

SKYBODY_INLINE bool write(const double* values, int count, float* rows) {
  Floats faults{};
  for (int first = 0; first < kGroupLanes; first += 4) {
    const double* in = values + first;
    float* row = rows + static_cast<std::ptrdiff_t>(first) * count;
    const auto write_four = [&](int k) __attribute__((always_inline)) {
      Floats v[4];
      for (int i = 0; i < 4; ++i) v[i] = to_floats(in + (k + i) * kGroupLanes, faults);
      transpose(v);
      for (int i = 0; i < 4; ++i) store_floats(row + i * count + k, v[i]);
    };
    for (int k = 0; k + 4 <= count; k += 4) write_four(k);
    if (count >= 4) {
      if (count % 4 != 0) write_four(count - 4);  // some of them once more
      continue;
    }
    for (int k = 0; k < count; ++k) {
      const Floats v = to_floats(in + k * kGroupLanes, faults);
      for (int i = 0; i < 4; ++i) row[i * count + k] = v[i];
    }
  }
  return !any(faults != Floats{});
}

SKYBODY_INLINE void end(const std::uint64_t* by_task, const std::uint64_t* step,
                        std::uint64_t horizon, std::uint64_t* status) {
  const std::uint64_t last = horizon > 0 ? horizon : ~std::uint64_t{0};
  for (int l = 0; l < kGroupLanes; ++l) {
    const std::uint64_t over = step[l] >= last ? std::uint64_t{kTruncated} : std::uint64_t{0};
    status[l] = (by_task[l] & (kTerminated | kTruncated)) | over;
  }
}

// One set of functions per instruction set. A macro, because the target is an attribute.
#define SKYBODY_ROW_KERNELS(NAME, TARGET)                                                         \
  SKYBODY_KERNEL(TARGET)                                                                          \
  bool read_clipped_##NAME(const float* rows, std::ptrdiff_t stride, int count, double* values) { \
    return read_clipped(rows, stride, count, values);                                             \
  }                                                                                               \
  SKYBODY_KERNEL(TARGET)                                                                          \
  void scale_##NAME(const double* action, int count, const double* low, const double* high,       \
                    double* command) {                                                            \
    scale(action, count, low, high, command);                                                     \
  }                                                                                               \
  SKYBODY_KERNEL(TARGET)                                                                          \
  bool are_finite_##NAME(const double* values, int count) { return are_finite(values, count); }   \
  SKYBODY_KERNEL(TARGET)                                                                          \
  bool write_##NAME(const double* values, int count, float* rows) {                               \
    return write(values, count, rows);                                                            \
  }                                                                                               \
  SKYBODY_KERNEL(TARGET)                                                                          \
  void end_##NAME(const std::uint64_t* by_task, const std::uint64_t* step, std::uint64_t horizon, \
                  std::uint64_t* status) {                                                        \
    end(by_task, step, horizon, status);                                                          \
  }                                                                                               \
  constexpr RowKernels k_##NAME{&read_clipped_##NAME, &scale_##NAME, &are_finite_##NAME,          \
                                &write_##NAME, &end_##NAME};
SKYBODY_ROW_KERNELS(v2, "arch=x86-64-v2")
SKYBODY_ROW_KERNELS(v3, "arch=x86-64-v3")
SKYBODY_ROW_KERNELS(v4, "arch=x86-64-v4")
#undef SKYBODY_ROW_KERNELS

}  // namespace

const RowKernels& row_kernels() {
  static const RowKernels chosen = [] {
    const Isa isa = best_isa();
    return isa == Isa::v4 ? k_v4 : isa == Isa::v3 ? k_v3 : k_v2;
  }();
  return chosen;
}

}  // namespace skybody
