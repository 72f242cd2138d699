// Operations that differ between a double, a pack and two packs in the limit loops: selections per
// lane, one machine instruction each, and memory access. The same bits as select() and max() of
// core/base.
#pragma once

#include <immintrin.h>

#include "core/base/math/math.h"

namespace skybody::bench::limit {

/// a if the mask is set, else b.
SKYBODY_INLINE double pick(bool mask, double a, double b) { return mask ? a : b; }
template <int W>
SKYBODY_INLINE Pack<W> pick(const Mask<W>& mask, const Pack<W>& a, const Pack<W>& b) {
  return Pack<W>(mask.v ? a.v : b.v);
}

/// The larger, or smaller, value; b if either is NaN.
SKYBODY_INLINE double larger(double a, double b) { return a > b ? a : b; }
SKYBODY_INLINE double smaller(double a, double b) { return a < b ? a : b; }
template <int W>
SKYBODY_INLINE Pack<W> larger(const Pack<W>& a, const Pack<W>& b) {
  return Pack<W>(a.v > b.v ? a.v : b.v);
}
template <int W>
SKYBODY_INLINE Pack<W> smaller(const Pack<W>& a, const Pack<W>& b) {
  return Pack<W>(a.v < b.v ? a.v : b.v);
}

SKYBODY_INLINE double magnitude(double x) { return __builtin_fabs(x); }
SKYBODY_INLINE double with_sign(double x, double sign) { return __builtin_copysign(x, sign); }
template <int W>
SKYBODY_INLINE Pack<W> magnitude(const Pack<W>& x) {
  return abs(x);
}
template <int W>
SKYBODY_INLINE Pack<W> with_sign(const Pack<W>& x, const Pack<W>& sign) {
  return copysign(x, sign);
}

/// The rare branches of angles, as in core/base.
template <class Real>
SKYBODY_INLINE Real full_atan2(const Real& y, const Real& x) {
  return atan2(y, x);
}
template <class Real>
SKYBODY_INLINE Real wrapped(const Real& x) {
  return wrap_angle(x);
}

template <class Real>
SKYBODY_INLINE Real root(const Real& x) {
  return sqrt(x);
}
template <class Real>
SKYBODY_INLINE Real exponential(const Real& x) {
  return exp(x);
}

template <class Real>
SKYBODY_INLINE SinCos<Real> sincos_of(const Real& x) {
  return sincos(x);
}

/// Bit i is the mask of lane i.
SKYBODY_INLINE std::uint32_t bits(bool mask) { return mask ? 1u : 0u; }
template <int W>
SKYBODY_INLINE std::uint32_t bits(const Mask<W>& mask) {
#ifdef __AVX512F__
  if constexpr (W == 8) {
    return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask.v));
  }
#endif
#ifdef __AVX__
  if constexpr (W == 4) {
    return static_cast<std::uint32_t>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask.v)));
  }
#endif
  return bits_from_mask(mask);
}

/// Lanes of a Real in consecutive doubles.
template <class Real>
struct LaneLoads {
  static constexpr int kCount = kLanesOf<Real>;
  static SKYBODY_INLINE Real load(const double* p) { return load_lanes<Real>(p); }
  static SKYBODY_INLINE void store(double* p, const Real& x) { store_lanes(p, x); }
};

/// atan2(y, x) for x > 0 and finite y; else some finite value. As core/base/math/math_atan.h,
/// without the cases of zeros, infinities and the left half plane.
template <class Real>
SKYBODY_INLINE Real atan2_right(const Real& y, const Real& x) {
  const Real ay = magnitude(y);
  const auto steep = ay > x;
  const Real den = larger(ay, x), num = smaller(ay, x);
  const auto shifted = num > 0.41421356237309503 * den;
  const Real ratio = pick(shifted, num - den, num) / pick(shifted, num + den, den);
  const Real core = skybody::detail::atan_kernel(ratio);
  const Real first = pick(shifted, Real(kQuarterPi), Real(0.0)) + core;
  return with_sign(pick(steep, kHalfPi - first, first), y);
}

}  // namespace skybody::bench::limit
