// Float rows of several environments to and from packs, transposed in registers.
#pragma once

#include <cstring>

#include "research/bench/limit/twin.h"

namespace skybody::bench::limit {

template <int W>
struct FloatLanes;
template <>
struct FloatLanes<4> {
  typedef float Native __attribute__((vector_size(16)));
};
template <>
struct FloatLanes<8> {
  typedef float Native __attribute__((vector_size(32)));
};
template <int W>
using Floats = typename FloatLanes<W>::Native;

/// Columns to rows in groups of four lanes. Afterwards vector i holds column values v[0..3] of lane
/// i, and with eight lanes those of lane i + 4 in its upper half. Its own inverse.
SKYBODY_INLINE void transpose4(Floats<4> (&v)[4]) {
  const Floats<4> a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
  const Floats<4> b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
  const Floats<4> c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Floats<4> d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}
SKYBODY_INLINE void transpose4(Floats<8> (&v)[4]) {
  const Floats<8> a = __builtin_shufflevector(v[0], v[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats<8> b = __builtin_shufflevector(v[2], v[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats<8> c = __builtin_shufflevector(v[0], v[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const Floats<8> d = __builtin_shufflevector(v[2], v[3], 2, 10, 3, 11, 6, 14, 7, 15);
  v[0] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
  v[1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  v[2] = __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
  v[3] = __builtin_shufflevector(c, d, 2, 3, 10, 11, 6, 7, 14, 15);
}

SKYBODY_INLINE void to_floats(const Pack<4>& x, Floats<4>& out) {
  out = __builtin_convertvector(x.v, Floats<4>);
}
SKYBODY_INLINE void to_floats(const Pack<8>& x, Floats<8>& out) {
  out = __builtin_convertvector(x.v, Floats<8>);
}

SKYBODY_INLINE void store(float* to, const Floats<4>& v) { std::memcpy(to, &v, sizeof(v)); }
SKYBODY_INLINE Floats<4> lower(const Floats<8>& v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3);
}
SKYBODY_INLINE Floats<4> upper(const Floats<8>& v) {
  return __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

/// Four columns from the first four floats of rows that are `stride` floats apart.
SKYBODY_INLINE void read_columns(const float* rows, double (&column)[4], int) {
  for (int i = 0; i < 4; ++i) column[i] = rows[i];
}
SKYBODY_INLINE void read_columns(const float* rows, Pack<4> (&column)[4], int stride) {
  Floats<4> v[4];
  for (int i = 0; i < 4; ++i) std::memcpy(&v[i], rows + i * stride, sizeof(v[i]));
  transpose4(v);
  for (int i = 0; i < 4; ++i) {
    column[i] = Pack<4>(__builtin_convertvector(v[i], lanes::Reals4));
  }
}
SKYBODY_INLINE void read_columns(const float* rows, Pack<8> (&column)[4], int stride) {
  Floats<8> v[4];
  for (int i = 0; i < 4; ++i) {
    Floats<4> low, high;
    std::memcpy(&low, rows + i * stride, sizeof(low));
    std::memcpy(&high, rows + (i + 4) * stride, sizeof(high));
    v[i] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  transpose4(v);
  for (int i = 0; i < 4; ++i) {
    column[i] = Pack<8>(__builtin_convertvector(v[i], lanes::Reals8));
  }
}
template <class R>
SKYBODY_INLINE void read_columns(const float* rows, Twin<R> (&column)[4], int stride) {
  R a[4], b[4];
  read_columns(rows, a, stride);
  read_columns(rows + stride * LaneLoads<R>::kCount, b, stride);
  for (int i = 0; i < 4; ++i) column[i] = {a[i], b[i]};
}

namespace detail {

/// Writes four values from `first` on into rows; values beyond the last one are arbitrary.
template <int N>
SKYBODY_INLINE void write_four(const Pack<4> (&values)[N], int first, float* rows, int stride) {
  Floats<4> v[4];
  for (int i = 0; i < 4; ++i) to_floats(values[first + i < N ? first + i : N - 1], v[i]);
  transpose4(v);
  for (int i = 0; i < 4; ++i) store(rows + i * stride + first, v[i]);
}
template <int N>
SKYBODY_INLINE void write_four(const Pack<8> (&values)[N], int first, float* rows, int stride) {
  Floats<8> v[4];
  for (int i = 0; i < 4; ++i) to_floats(values[first + i < N ? first + i : N - 1], v[i]);
  transpose4(v);
  for (int i = 0; i < 4; ++i) {
    store(rows + i * stride + first, lower(v[i]));
    store(rows + (i + 4) * stride + first, upper(v[i]));
  }
}

}  // namespace detail

/// Writes N columns to the lanes' rows, `stride` floats apart. Overwrites up to three floats after
/// the N, so write those afterwards.
template <int N>
SKYBODY_INLINE void write_values(const double (&values)[N], float* row, int) {
  for (int k = 0; k < N; ++k) row[k] = static_cast<float>(values[k]);
}
template <int W, int N>
SKYBODY_INLINE void write_values(const Pack<W> (&values)[N], float* rows, int stride) {
  for (int k = 0; k < N; k += 4) detail::write_four(values, k, rows, stride);
}
template <class R, int N>
SKYBODY_INLINE void write_values(const Twin<R> (&values)[N], float* rows, int stride) {
  R a[N], b[N];
  for (int k = 0; k < N; ++k) {
    a[k] = values[k].a;
    b[k] = values[k].b;
  }
  write_values(a, rows, stride);
  write_values(b, rows + LaneLoads<R>::kCount * stride, stride);
}

/// One float per lane, contiguous.
SKYBODY_INLINE void write_floats(double x, float* to) { *to = static_cast<float>(x); }
template <int W>
SKYBODY_INLINE void write_floats(const Pack<W>& x, float* to) {
  Floats<W> v;
  to_floats(x, v);
  std::memcpy(to, &v, sizeof(v));
}
template <class R>
SKYBODY_INLINE void write_floats(const Twin<R>& x, float* to) {
  write_floats(x.a, to);
  write_floats(x.b, to + LaneLoads<R>::kCount);
}

}  // namespace skybody::bench::limit
