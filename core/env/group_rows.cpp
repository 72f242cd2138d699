#include "core/env/group_rows.h"

#include <cstring>

#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/base/math_basic.h"
#include "core/base/octets.h"
#include "core/base/pack.h"
#include "core/model/layout.h"
#include "core/physics/lane_values.h"

namespace skybody {
namespace {

// A piece of a table: W lanes times four values, transposed in registers. Two pieces of four lanes,
// or one of eight, make an octet.
template <int W>
struct FloatPack;
template <>
struct FloatPack<4> {
  typedef float Native __attribute__((vector_size(16)));
};
template <>
struct FloatPack<8> {
  typedef float Native __attribute__((vector_size(32)));
};
template <int W>
using Floats = typename FloatPack<W>::Native;

template <class Vector>
SKYBODY_INLINE void load(const float* p, Vector& v) {
  std::memcpy(&v, p, sizeof(v));
}
template <class Vector>
SKYBODY_INLINE void store(float* p, const Vector& v) {
  std::memcpy(p, &v, sizeof(v));
}

// Columns a, b, c, d of four lanes become rows a0 b0 c0 d0, a1 b1 c1 d1, ...; and back. Of eight
// lanes, row i is followed by row i + 4.
SKYBODY_INLINE void transpose(Floats<4> (&v)[4]) {
  const Floats<4> a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
  const Floats<4> b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
  const Floats<4> c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Floats<4> d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}
SKYBODY_INLINE void transpose(Floats<8> (&v)[4]) {
  const Floats<8> a = __builtin_shufflevector(v[0], v[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats<8> b = __builtin_shufflevector(v[2], v[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats<8> c = __builtin_shufflevector(v[0], v[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const Floats<8> d = __builtin_shufflevector(v[2], v[3], 2, 10, 3, 11, 6, 14, 7, 15);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// Four values of lane i, and of lane i + 4 where there are eight.
SKYBODY_INLINE void load_rows(const float* row, std::ptrdiff_t, Floats<4>& v) { load(row, v); }
SKYBODY_INLINE void load_rows(const float* row, std::ptrdiff_t stride, Floats<8>& v) {
  Floats<4> low, high;
  load(row, low);
  load(row + 4 * stride, high);
  v = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
SKYBODY_INLINE void store_rows(float* row, std::ptrdiff_t, const Floats<4>& v) { store(row, v); }
SKYBODY_INLINE void store_rows(float* row, std::ptrdiff_t stride, const Floats<8>& v) {
  store(row, __builtin_shufflevector(v, v, 0, 1, 2, 3));
  store(row + 4 * stride, __builtin_shufflevector(v, v, 4, 5, 6, 7));
}

template <class Vector>
SKYBODY_INLINE void to_floats(const double* lanes, Vector& v) {
  constexpr int W = sizeof(Vector) / sizeof(float);
  v = __builtin_convertvector(load_lanes<Pack<W>>(lanes).v, Vector);
}

/// Whether all lanes of a sum are finite: if so, all its terms were. (Finite ones whose sum is not
/// are rare, and whoever asks has a slower way to be sure.)
template <class Vector>
SKYBODY_INLINE bool is_finite(const Vector& sum) {
  float lanes[sizeof(Vector) / sizeof(float)];
  store(lanes, Vector(sum - sum));
  float faults = 0.0f;
  for (const float lane : lanes) faults += lane;
  return faults == 0.0f;
}

SKYBODY_INLINE double clipped(float value) {
  const double a = value;
  return a < -1.0 ? -1.0 : (a > 1.0 ? 1.0 : a);
}

/// Whether all values of eight rows are finite (see is_finite).
SKYBODY_INLINE bool are_rows_finite(const float* rows, std::ptrdiff_t stride, int count) {
  Floats<4> sum{};
  float rest = 0.0f;
  for (int l = 0; l < kOctet; ++l, rows += stride) {
    int k = 0;
    for (; k + 4 <= count; k += 4) {
      Floats<4> v;
      load(rows + k, v);
      sum += v;
    }
    for (; k < count; ++k) rest += rows[k];
  }
  return is_finite(sum) && rest - rest == 0.0f;
}

template <int W>
SKYBODY_INLINE bool read_octet(const float* rows, std::ptrdiff_t stride, int count,
                               double* values) {
  if (!are_rows_finite(rows, stride, count)) return false;
  for (int first = 0; first < kOctet; first += W) {
    const float* row = rows + first * stride;
    double* out = values + first;
    int k = 0;
    for (; k + 4 <= count; k += 4) {
      Floats<W> v[4];
      for (int i = 0; i < 4; ++i) load_rows(row + i * stride + k, stride, v[i]);
      transpose(v);
      for (int i = 0; i < 4; ++i) {
        const Pack<W> a(__builtin_convertvector(v[i], typename Pack<W>::Native));
        store_lanes(out + (k + i) * kGroupLanes, clamp(a, Pack<W>(-1.0), Pack<W>(1.0)));
      }
    }
    for (; k < count; ++k) {
      for (int i = 0; i < W; ++i) out[k * kGroupLanes + i] = clipped(row[i * stride + k]);
    }
  }
  return true;
}

template <int W>
SKYBODY_INLINE std::uint32_t read_clipped(std::uint32_t octets, const float* rows,
                                          std::ptrdiff_t stride, int count, double* values) {
  std::uint32_t read = 0;
  each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
    if (read_octet<W>(rows + first * stride, stride, count, values + first)) read |= 0xffu << first;
  });
  return read;
}

template <int W>
SKYBODY_INLINE void scale(std::uint32_t octets, const double* action, int count, const double* low,
                          const double* high, double* command) {
  for (int k = 0; k < count; ++k, action += kGroupLanes, command += kGroupLanes) {
    const Pack<W> from(low[k]), range(high[k] - low[k]);
    each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
      for (int l = first; l < first + kOctet; l += W) {
        const Pack<W> a = load_lanes<Pack<W>>(action + l);
        store_lanes(command + l, from + 0.5 * (a + 1.0) * range);
      }
    });
  }
}

/// The usual case: without masks, value after value, as memory has them.
template <int W>
SKYBODY_INLINE void copy_octets(std::uint32_t octets, const double* from, int count, double* to) {
  for (int k = 0; k < count; ++k, from += kGroupLanes, to += kGroupLanes) {
    each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
      for (int l = first; l < first + kOctet; l += W) {
        store_lanes(to + l, load_lanes<Pack<W>>(from + l));
      }
    });
  }
}

template <int W>
SKYBODY_INLINE void copy(std::uint32_t lanes, const double* from, int count, double* to) {
  if (lanes == whole_octets(lanes)) return copy_octets<W>(lanes, from, count, to);
  for (int first = 0; first < kGroupLanes; first += W) {
    const std::uint32_t bits = (lanes >> first) & ((1u << W) - 1u);
    if (bits == 0) continue;
    const Mask<W> mask = mask_from_bits<Pack<W>>(bits);
    for (int k = 0; k < count; ++k) {
      const int at = k * kGroupLanes + first;
      store_lanes(to + at, load_lanes<Pack<W>>(from + at), mask);
    }
  }
}

template <int W>
SKYBODY_INLINE std::uint32_t are_finite(std::uint32_t octets, const double* values, int count) {
  std::uint32_t finite = 0;
  each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
    Floats<W> sum{};
    for (int k = 0; k < count; ++k) {
      for (int l = first; l < first + kOctet; l += W) {
        Floats<W> v;
        to_floats(values + k * kGroupLanes + l, v);
        sum += v;
      }
    }
    if (is_finite(sum)) finite |= 0xffu << first;
  });
  return finite;
}

template <int W>
SKYBODY_INLINE bool write_octet(const double* values, int count, float* rows) {
  Floats<W> sum{};
  for (int first = 0; first < kOctet; first += W) {
    const double* in = values + first;
    float* row = rows + static_cast<std::ptrdiff_t>(first) * count;
    const auto write_four = [&](int k) SKYBODY_INLINE_LAMBDA {
      Floats<W> v[4];
      for (int i = 0; i < 4; ++i) {
        to_floats(in + (k + i) * kGroupLanes, v[i]);
        sum += v[i];
      }
      transpose(v);
      for (int i = 0; i < 4; ++i) store_rows(row + i * count + k, count, v[i]);
    };
    int k = 0;
    for (; k + 4 <= count; k += 4) write_four(k);
    if (k < count && count >= 4) {
      write_four(count - 4);  // some of them once more
      continue;
    }
    for (; k < count; ++k) {
      Floats<W> v;
      to_floats(in + k * kGroupLanes, v);
      sum += v;
      if (count == 1) {
        store(row, v);
      } else {
        for (int i = 0; i < W; ++i) row[i * count + k] = v[i];
      }
    }
  }
  return is_finite(sum);
}

template <int W>
SKYBODY_INLINE std::uint32_t write(std::uint32_t octets, const double* values, int count,
                                   float* rows) {
  std::uint32_t finite = 0;
  each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
    float* row = rows + static_cast<std::ptrdiff_t>(first) * count;
    if (write_octet<W>(values + first, count, row)) finite |= 0xffu << first;
  });
  return finite;
}

template <int W>
SKYBODY_INLINE void end(std::uint32_t octets, const std::uint64_t* by_task,
                        const std::uint64_t* step, std::uint64_t horizon, std::uint64_t* status,
                        std::uint64_t* rows) {
  using Words = Word<Pack<W>>;
  const Words last(horizon > 0 ? horizon : std::uint64_t{1} << 62), truncated(int{kTruncated});
  each_octet(octets, [&](int first) SKYBODY_INLINE_LAMBDA {
    for (int l = first; l < first + kOctet; l += W) {
      // All ones where the step is not below the last: their difference has no sign then.
      const Words over = ((load_words<Pack<W>>(step + l) - last) >> 63) - 1;
      const Words result =
          (load_words<Pack<W>>(by_task + l) & int{kTerminated | kTruncated}) | (over & truncated);
      store_words(status + l, result);
      store_words(rows + l, result);
    }
  });
}

// One set of functions per instruction set. A macro, because the target is an attribute.
#define SKYBODY_ROW_KERNELS(NAME, TARGET, W)                                                       \
  SKYBODY_KERNEL(TARGET)                                                                           \
  std::uint32_t read_clipped_##NAME(std::uint32_t octets, const float* rows,                       \
                                    std::ptrdiff_t stride, int count, double* values) {            \
    return read_clipped<W>(octets, rows, stride, count, values);                                   \
  }                                                                                                \
  SKYBODY_KERNEL(TARGET)                                                                           \
  void scale_##NAME(std::uint32_t octets, const double* action, int count, const double* low,      \
                    const double* high, double* command) {                                         \
    scale<W>(octets, action, count, low, high, command);                                           \
  }                                                                                                \
  SKYBODY_KERNEL(TARGET)                                                                           \
  void copy_##NAME(std::uint32_t lanes, const double* from, int count, double* to) {               \
    copy<W>(lanes, from, count, to);                                                               \
  }                                                                                                \
  SKYBODY_KERNEL(TARGET)                                                                           \
  std::uint32_t are_finite_##NAME(std::uint32_t octets, const double* values, int count) {         \
    return are_finite<W>(octets, values, count);                                                   \
  }                                                                                                \
  SKYBODY_KERNEL(TARGET)                                                                           \
  std::uint32_t write_##NAME(std::uint32_t octets, const double* values, int count, float* rows) { \
    return write<W>(octets, values, count, rows);                                                  \
  }                                                                                                \
  SKYBODY_KERNEL(TARGET)                                                                           \
  void end_##NAME(std::uint32_t octets, const std::uint64_t* by_task, const std::uint64_t* step,   \
                  std::uint64_t horizon, std::uint64_t* status, std::uint64_t* rows) {             \
    end<W>(octets, by_task, step, horizon, status, rows);                                          \
  }                                                                                                \
  constexpr RowKernels k_##NAME{&read_clipped_##NAME, &scale_##NAME, &copy_##NAME,                 \
                                &are_finite_##NAME,   &write_##NAME, &end_##NAME};
SKYBODY_ROW_KERNELS(v2, "arch=x86-64-v2", 4)
SKYBODY_ROW_KERNELS(v3, "arch=x86-64-v3", 4)
SKYBODY_ROW_KERNELS(v4, "arch=x86-64-v4", 8)
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
