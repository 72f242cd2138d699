// Elementary arithmetic on Real: roots, rounding, signs, ranges. See core/base/math/math.h.
#pragma once

#include "core/base/simd/pack.h"

namespace skybody {

constexpr double kPi = 3.14159265358979323846;          ///< [rad]
constexpr double kTwoPi = 6.28318530717958647693;       ///< [rad]
constexpr double kHalfPi = 1.57079632679489661923;      ///< [rad]
constexpr double kQuarterPi = 0.785398163397448309616;  ///< [rad]
constexpr double kLn2 = 0.693147180559945309417;        ///< natural logarithm of 2
constexpr double kLargest = 1.7976931348623157e308;     ///< the largest finite double
constexpr double kInfinity = __builtin_inf();
constexpr double kNan = __builtin_nan("");

namespace detail {
/// c0 + x (c1 + x (c2 + ...)), Horner's rule from the inside out.
template <class Real>
SKYBODY_INLINE Real polynomial(const Real&, double c0) {
  return c0;
}
template <class Real, class... Rest>
SKYBODY_INLINE Real polynomial(const Real& x, double c0, Rest... rest) {
  return c0 + x * polynomial(x, rest...);
}
}  // namespace detail

/// Square root, correctly rounded; NaN for x < 0, -0 for -0.
#ifdef __SSE2__
SKYBODY_INLINE double sqrt(double x) { return _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set_sd(x))); }
#else
SKYBODY_INLINE double sqrt(double x) { return __builtin_sqrt(x); }
#endif
template <int W>
SKYBODY_INLINE Pack<W> sqrt(const Pack<W>& x) {
  Pack<W> root;
  lanes::sqrt(x.v, root.v);
  return root;
}

/// |x|: clears the sign bit, also of zeros and NaN.
template <class Real>
SKYBODY_INLINE Real abs(const Real& x) {
  return bit_cast_real(bit_cast_word(x) & ~detail::kSignBit);
}

/// The magnitude of x with the sign bit of `sign`.
template <class Real>
SKYBODY_INLINE Real copysign(const Real& x, const Real& sign) {
  return bit_cast_real((bit_cast_word(x) & ~detail::kSignBit) |
                       (bit_cast_word(sign) & detail::kSignBit));
}

/// The smaller value; b if either is NaN, or if they are equal.
template <class Real>
SKYBODY_INLINE Real min(const Real& a, const Real& b) {
  return select(a < b, a, b);
}
/// The larger value; b if either is NaN, or if they are equal.
template <class Real>
SKYBODY_INLINE Real max(const Real& a, const Real& b) {
  return select(a > b, a, b);
}
/// x limited to [low, high], low <= high; NaN stays NaN.
template <class Real>
SKYBODY_INLINE Real clamp(const Real& x, const Real& low, const Real& high) {
  const Real above = select(x < low, low, x);
  return select(above > high, high, above);
}
/// Mixed overloads: `min(x, 1.0)` and `clamp(x, 0.0, 1.0)` also compile for packs.
template <int W>
SKYBODY_INLINE Pack<W> min(const Pack<W>& a, double b) {
  return min(a, Pack<W>(b));
}
template <int W>
SKYBODY_INLINE Pack<W> min(double a, const Pack<W>& b) {
  return min(Pack<W>(a), b);
}
template <int W>
SKYBODY_INLINE Pack<W> max(const Pack<W>& a, double b) {
  return max(a, Pack<W>(b));
}
template <int W>
SKYBODY_INLINE Pack<W> max(double a, const Pack<W>& b) {
  return max(Pack<W>(a), b);
}
template <int W>
SKYBODY_INLINE Pack<W> clamp(const Pack<W>& x, double low, double high) {
  return clamp(x, Pack<W>(low), Pack<W>(high));
}
template <int W>
SKYBODY_INLINE Pack<W> copysign(double x, const Pack<W>& sign) {
  return copysign(Pack<W>(x), sign);
}
template <int W>
SKYBODY_INLINE Pack<W> copysign(const Pack<W>& x, double sign) {
  return copysign(x, Pack<W>(sign));
}

/// The nearest whole number, halves to even; keeps the sign of zero, infinities and NaN.
/// Adding and subtracting 2^52 rounds off the fraction of every smaller magnitude.
template <class Real>
SKYBODY_INLINE Real round_half_even(const Real& x) {
  const Real magnitude = abs(x);
  const Real rounded = (magnitude + detail::kTwo52) - detail::kTwo52;
  return copysign(select(magnitude < detail::kTwo52, rounded, magnitude), x);
}

/// The largest whole number <= x; keeps the sign of zero, infinities and NaN.
template <class Real>
SKYBODY_INLINE Real floor(const Real& x) {
  const Real rounded = round_half_even(x);
  return select(rounded > x, rounded - 1.0, rounded);
}

template <class Real>
SKYBODY_INLINE MaskOf<Real> is_nan(const Real& x) {
  return x != x;
}
/// Neither infinite nor NaN.
template <class Real>
SKYBODY_INLINE MaskOf<Real> is_finite(const Real& x) {
  return abs(x) <= kLargest;
}

template <class Real>
SKYBODY_INLINE Real square(const Real& x) {
  return x * x;
}
/// x^(3/2), x >= 0; NaN below.
template <class Real>
SKYBODY_INLINE Real pow_3_2(const Real& x) {
  return x * sqrt(x);
}
/// sqrt(x^2 + y^2) without scaling: overflows above 1e154, loses precision below 1e-146.
template <class Real>
SKYBODY_INLINE Real norm(const Real& x, const Real& y) {
  return sqrt(x * x + y * y);
}
/// sqrt((x^2 + y^2) + z^2), with the same limits.
template <class Real>
SKYBODY_INLINE Real norm(const Real& x, const Real& y, const Real& z) {
  return sqrt((x * x + y * y) + z * z);
}

}  // namespace skybody
