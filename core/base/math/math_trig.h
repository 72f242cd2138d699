// sin, cos, tan and angle wrapping on Real. See core/base/math/math.h.
#pragma once

#include "core/base/math/math_basic.h"

namespace skybody {

/// Sine and cosine of one angle.
template <class Real>
struct SinCos {
  Real sin;
  Real cos;
};

namespace detail {

// pi/2 in three parts of 33 bits and a remainder (fdlibm e_rem_pio2.c): products of the parts with
// whole numbers below 2^20 are exact.
constexpr double kHalfPi1 = 1.57079632673412561417e+00;
constexpr double kHalfPi2 = 6.07710050630396597660e-11;
constexpr double kHalfPi3 = 2.02226624871116645580e-21;
constexpr double kHalfPi4 = 8.47842766036889956997e-32;
constexpr double kTwoOverPi = 6.36619772367581382433e-01;

/// a + b as a rounded sum and its exact error (Knuth's TwoSum).
template <class Real>
struct TwoSum {
  Real sum;
  Real error;
};
template <class Real>
SKYBODY_INLINE TwoSum<Real> two_sum(const Real& a, const Real& b) {
  const Real sum = a + b;
  const Real b_part = sum - a;
  const Real a_part = sum - b_part;
  return {sum, (a - a_part) + (b - b_part)};
}

/// x = n pi/2 + (high + low), |high| <= pi/4.
template <class Real>
struct Quadrant {
  Real n;
  Real high;
  Real low;
};
template <class Real>
SKYBODY_INLINE Quadrant<Real> reduce_to_quadrant(const Real& x) {
  const Real n = round_half_even(x * kTwoOverPi);
  const Real first = x - n * kHalfPi1;
  const TwoSum<Real> second = two_sum(first, -(n * kHalfPi2));
  const TwoSum<Real> third = two_sum(second.sum, -(n * kHalfPi3));
  const Real rest = (second.error + third.error) - n * kHalfPi4;
  const Real high = third.sum + rest;
  // Beyond the documented range the remainder is noise; clamp it to the interval of the series.
  const Real limited = clamp(high, Real(-0.7854), Real(0.7854));
  return {n, limited, select(limited == high, (third.sum - high) + rest, Real(0.0))};
}

/// sin(x + y) for |x| <= pi/4, y its tail. fdlibm k_sin.c, error below 2^-58.
template <class Real>
SKYBODY_INLINE Real sin_kernel(const Real& x, const Real& y) {
  const Real z = x * x;
  const Real v = z * x;
  const Real r = polynomial(z, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
                            2.75573137070700676789e-06, -2.50507602534068634195e-08,
                            1.58969099521155010221e-10);
  return x - ((z * (0.5 * y - v * r) - y) - v * -1.66666666666666324348e-01);
}

/// cos(x + y) for |x| <= pi/4, y its tail. fdlibm (FreeBSD) k_cos.c, error below 2^-58.
template <class Real>
SKYBODY_INLINE Real cos_kernel(const Real& x, const Real& y) {
  const Real z = x * x;
  const Real r = polynomial(z, 4.16666666666666019037e-02, -1.38888888888741095749e-03,
                            2.48015872894767294178e-05, -2.75573143513906633035e-07,
                            2.08757232129817482790e-09, -1.13596475577881948265e-11);
  const Real half = 0.5 * z;
  const Real w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * (z * r) - x * y));
}

}  // namespace detail

/// Sine and cosine of x [rad]. Error below 1 ulp for |x| <= 1e6; absolute error below 1 ulp of x up
/// to 1e15; beyond, a bounded but meaningless value. NaN for infinities and NaN. sin(-0) is -0.
template <class Real>
SKYBODY_INLINE SinCos<Real> sincos(const Real& x) {
  const detail::Quadrant<Real> quadrant = detail::reduce_to_quadrant(x);
  const Real s = detail::sin_kernel(quadrant.high, quadrant.low);
  const Real c = detail::cos_kernel(quadrant.high, quadrant.low);
  const Word<Real> n = bit_cast_word(quadrant.n + detail::kRoundMagic);
  const auto swap = (n & 1) != Word<Real>(0);
  const Word<Real> sin_sign = (n & 2) << 62;
  const Word<Real> cos_sign = ((n + 1) & 2) << 62;
  const Real sine = bit_cast_real(bit_cast_word(select(swap, c, s)) ^ sin_sign);
  const Real cosine = bit_cast_real(bit_cast_word(select(swap, s, c)) ^ cos_sign);
  return {select(abs(x) < 7.450580596923828e-9, x, sine), cosine};
}

/// Sine of x [rad], as `sincos`.
template <class Real>
SKYBODY_INLINE Real sin(const Real& x) {
  return sincos(x).sin;
}
/// Cosine of x [rad], as `sincos`.
template <class Real>
SKYBODY_INLINE Real cos(const Real& x) {
  return sincos(x).cos;
}
/// Tangent of x [rad], sine over cosine. Error below 2.5 ulp for |x| <= 1e6.
template <class Real>
SKYBODY_INLINE Real tan(const Real& x) {
  const SinCos<Real> both = sincos(x);
  return both.sin / both.cos;
}

/// The equivalent angle in (-pi, pi] [rad]. Exact reduction for |x| <= 3e6; beyond, error below
/// 1 ulp of x up to 1e15. NaN for infinities and NaN.
template <class Real>
SKYBODY_INLINE Real wrap_angle(const Real& x) {
  const auto is_inside = abs(x) < kPi;
  if (all(is_inside)) return x;
  const Real n = 4.0 * round_half_even(x * (0.25 * detail::kTwoOverPi));
  const Real first = (x - n * detail::kHalfPi1) - n * detail::kHalfPi2;
  const Real r = first - n * detail::kHalfPi3;
  const Real low = select(r > kPi, r - kTwoPi, r);
  return select(is_inside, x, select(low <= -kPi, low + kTwoPi, low));
}

}  // namespace skybody
