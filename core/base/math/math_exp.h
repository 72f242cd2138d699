// exp, expm1 and log on Real. See core/base/math/math.h.
#pragma once

#include "core/base/math/math_basic.h"

namespace skybody {
namespace detail {

// ln 2 in two parts; the first has 32 significant bits, so its product with any exponent is exact.
// Source: fdlibm e_exp.c.
constexpr double kLn2High = 6.93147180369123816490e-01;
constexpr double kLn2Low = 1.90821492927058770002e-10;
constexpr double kInverseLn2 = 1.44269504088896338700e+00;

/// 2^n for a whole number n, -1022 <= n <= 1023, by writing the exponent.
template <class Real>
SKYBODY_INLINE Real power_of_two(const Real& n) {
  return bit_cast_real((bit_cast_word(n + kRoundMagic) + 1023) << 52);
}

/// x = n ln 2 + r with |r| <= ln 2 / 2, and expm1(r). |x| < 1000.
template <class Real>
struct ExpParts {
  Real n;       ///< whole number
  Real expm1r;  ///< exp(r) - 1
};

/// exp(r) - 1 = r + r^2 (1/2! + r/3! + ... + r^11/13!); the remainder of the series is below 2^-57.
template <class Real>
SKYBODY_INLINE ExpParts<Real> exp_parts(const Real& x) {
  const Real n = round_half_even(x * kInverseLn2);
  const Real high = x - n * kLn2High;
  const Real low = n * kLn2Low;
  const Real r = high - low;
  const Real rest = (high - r) - low;
  const Real series =
      polynomial(r, 0.5, 1.66666666666666666667e-1, 4.16666666666666666667e-2,
                 8.33333333333333333333e-3, 1.38888888888888888889e-3, 1.98412698412698412698e-4,
                 2.48015873015873015873e-5, 2.75573192239858906526e-6, 2.75573192239858906526e-7,
                 2.50521083854417187751e-8, 2.08767569878680989792e-9, 1.60590438368216145994e-10);
  // exp(r + rest) - 1 = expm1(r) + rest (1 + r) to first order.
  return {n, r + (r * r * series + (rest + rest * r))};
}

}  // namespace detail

/// e^x for every x. Error below 1 ulp for normal results. Overflows to infinity above 709.78,
/// underflows through the denormals to zero below -708.4; NaN gives NaN.
/// Method: x = n ln 2 + r (Cody-Waite), Taylor series, exponent in two factors.
template <class Real>
SKYBODY_INLINE Real exp(const Real& x) {
  const detail::ExpParts<Real> parts = detail::exp_parts(clamp(x, Real(-746.0), Real(710.0)));
  const Real half = round_half_even(parts.n * 0.5);
  return ((1.0 + parts.expm1r) * detail::power_of_two(half)) * detail::power_of_two(parts.n - half);
}

/// e^x - 1 for every x, accurate also near zero. Error below 2 ulp. Keeps the sign of zero.
template <class Real>
SKYBODY_INLINE Real expm1(const Real& x) {
  const detail::ExpParts<Real> parts = detail::exp_parts(clamp(x, Real(-40.0), Real(710.0)));
  const Real half = round_half_even(parts.n * 0.5);
  const Real rest = parts.n - half;
  const Real first = detail::power_of_two(half);
  // 2^n (1 + p) - 1 = 2^rest (2^half p + (2^half - 2^-rest))
  const Real sum = first * parts.expm1r + (first - detail::power_of_two(-rest));
  const Real result = sum * detail::power_of_two(rest);
  return select(abs(x) < 5.5511151231257827e-17, x, result);
}

/// Natural logarithm. Error below 1 ulp. -infinity for zeros, NaN below zero; infinity and NaN are
/// returned unchanged. Method: fdlibm e_log.c (Sun Microsystems, 1993), mantissa in
/// [sqrt(1/2), sqrt(2)).
template <class Real>
SKYBODY_INLINE Real log(const Real& x) {
  constexpr std::uint64_t kSqrtHalf = 0x3fe6a09e00000000ull;
  constexpr std::uint64_t kOne = 0x3ff0000000000000ull;
  const auto tiny = x < 2.2250738585072014e-308;
  const Real normal = select(tiny, x * 18014398509481984.0, x);  // denormals: times 2^54
  const Word<Real> shifted = bit_cast_word(normal) + (kOne - kSqrtHalf);
  const Real k = to_real(shifted >> 52) - select(tiny, Real(1077.0), Real(1023.0));
  const Real f = bit_cast_real((shifted & detail::kFractionBits) + kSqrtHalf) - 1.0;
  const Real s = f / (2.0 + f);
  const Real z = s * s;
  const Real series = z * detail::polynomial(z, 6.666666666666735130e-01, 3.999999999940941908e-01,
                                             2.857142874366239149e-01, 2.222219843214978396e-01,
                                             1.818357216161805012e-01, 1.531383769920937332e-01,
                                             1.479819860511658591e-01);
  const Real half_square = 0.5 * f * f;
  const Real value = k * detail::kLn2High -
                     ((half_square - (s * (half_square + series) + k * detail::kLn2Low)) - f);
  const Real above = select(x < kInfinity, value, x);  // infinity and NaN unchanged
  const Real not_zero = select(x < 0.0, Real(kNan), above);
  return select(x == 0.0, Real(-kInfinity), not_zero);
}

}  // namespace skybody
