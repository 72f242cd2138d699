// Elementary functions of sixteen floats: our own rational or polynomial fits (minimax by Lawson's
// reweighting, over the stated intervals), evaluated by Horner's rule. Errors are in units in the
// last place (ulp), over all floats of the range; tests/unit/learn/functions_test.cpp measures
// them.
#pragma once

#include "learn/network/kernels/floats.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

/// 2^k and r with x = k ln 2 + r, |r| <= ln 2 / 2. For |x| < 2^21 ln 2.
struct ReducedExponent {
  Floats power, rest;
};
SKYBODY_KERNEL ReducedExponent reduce_exponent(const Floats& x) {
  // Adding 1.5 * 2^23 rounds to an integer, which is then in the lowest bits.
  const Floats shift = floats(12582912.0f);
  const Floats shifted = fma(x, floats(1.44269504088896f), shift);
  const Floats k = shifted - shift;
  // ln 2 in two parts. The first has 9 bits, so that its product with k is exact.
  Floats rest = fma(k, floats(-0.693359375f), x);
  rest = fma(k, floats(2.12194440054690571e-4f), rest);
  return {of_bits(left<23>(bits(shifted)) + ints(0x3f800000)), rest};
}

/// e^r - 1 for |r| <= ln 2 / 2.
SKYBODY_KERNEL Floats small_expm1(const Floats& r) {
  constexpr float kCoefficients[] = {0.4999999814961764f, 0.16666543424267583f,
                                     0.04166720071240716f, 0.008366547131436145f,
                                     0.0013882516413217508f};
  return fma(r * r, polynomial(kCoefficients, r), r);
}

/// Within 2 ulp for -87 <= x <= 88; clamped beyond. NaN gives NaN.
SKYBODY_KERNEL Floats exp(const Floats& x) {
  const ReducedExponent e = reduce_exponent(min(floats(88.0f), max(floats(-87.0f), x)));
  return fma(small_expm1(e.rest), e.power, e.power);
}

/// e^x - 1 for x <= 0, within 3 ulp.
SKYBODY_KERNEL Floats expm1_of_negative(const Floats& x) {
  const ReducedExponent e = reduce_exponent(max(floats(-87.0f), x));
  return fma(small_expm1(e.rest), e.power, e.power - floats(1.0f));
}

/// Natural logarithm of a normal number > 0, within 3 ulp.
SKYBODY_KERNEL Floats log(const Floats& x) {
  constexpr float kCoefficients[] = {0.6666677674173606f, 0.3997748394425161f, 0.2987357329354949f};
  // x = 2^k m with m in [sqrt(1/2), sqrt(2)).
  constexpr int32_t kRootOfHalf = 0x3f3504f3;
  const Ints raised = bits(x) + ints(0x3f800000 - kRootOfHalf);
  const Floats k = to_floats(right<23>(raised) + ints(-127));
  const Floats m = of_bits((raised & ints(0x007fffff)) + ints(kRootOfHalf));
  // log(m) = 2 atanh(s) = 2 s + s^3 p(s^2) with s = (m - 1) / (m + 1). As f = m - 1 is exact and
  // 2 s = f - f s, the leading part is not rounded.
  const Floats f = m - floats(1.0f);
  const Floats s = f / (m + floats(1.0f));
  const Floats square = s * s;
  const Floats tail = fma(square, polynomial(kCoefficients, square), floats(0.0f) - f);
  const Floats log_m = fma(s, tail, f);
  return fma(k, floats(0.693359375f), fma(k, floats(-2.12194440054690571e-4f), log_m));
}

/// Within 5 ulp; NaN gives NaN.
SKYBODY_KERNEL Floats tanh(const Floats& x) {
  constexpr float kNumerator[] = {0.999999979037096f, 0.1337972327137798f, 0.003494040763149138f,
                                  2.05835779467487e-05f, 1.3319194924551621e-08f};
  constexpr float kDenominator[] = {1.0f, 0.46713038518437955f, 0.025871097132413354f,
                                    0.0003283102756136339f, 7.762072149319023e-07f};
  // Beyond 9.02 the nearest float is 1. A NaN passes as the second argument.
  const Floats bound = floats(9.02f), one = floats(1.0f);
  const Floats a = max(floats(0.0f) - bound, min(bound, x));
  const Floats square = a * a;
  const Floats y = a * polynomial(kNumerator, square) / polynomial(kDenominator, square);
  return max(floats(0.0f) - one, min(one, y));
}

/// 1 / (1 + e^-x), within 4 ulp for |x| <= 87; NaN gives NaN.
SKYBODY_KERNEL Floats sigmoid(const Floats& x) {
  return floats(1.0f) / (floats(1.0f) + exp(floats(0.0f) - x));
}

/// Sine and cosine for |x| <= pi / 4, within 2 ulp.
struct SmallAngle {
  Floats sine, cosine;
};
SKYBODY_KERNEL SmallAngle sincos_of_small(const Floats& x) {
  constexpr float kSine[] = {-0.16666654573139425f, 0.00833215840984482f, -0.00019514957652745244f};
  constexpr float kCosine[] = {0.04166664561880152f, -0.001388731306281873f,
                               2.443278510489102e-05f};
  const Floats square = x * x;
  const Floats half = fma(square, floats(-0.5f), floats(1.0f));
  return {fma(x * square, polynomial(kSine, square), x),
          fma(square * square, polynomial(kCosine, square), half)};
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
