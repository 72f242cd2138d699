// The quantile of the standard normal distribution, and its inverse. On double and packs.
//
// M. J. Wichura, "Algorithm AS 241: The percentage points of the normal distribution", Applied
// Statistics 37 (1988), 477: PPND16, relative accuracy about 1e-16.
#pragma once

#include "core/base/math/math.h"

namespace skybody {
namespace detail {

/// (c0 + c1 x + ... + c7 x^7) / (1 + d1 x + ... + d7 x^7).
template <class Real>
SKYBODY_INLINE Real rational_7(const Real& x, const double (&c)[8], const double (&d)[7]) {
  Real above(c[7]), below(d[6]);
  for (int k = 6; k >= 0; --k) above = above * x + c[k];
  for (int k = 5; k >= 0; --k) below = below * x + d[k];
  return above / (below * x + 1.0);
}

// Coefficients of the middle, |p - 1/2| <= 0.425, in the variable 0.180625 - (p - 1/2)^2.
constexpr double kMiddleAbove[8] = {3.3871328727963666080e0, 1.3314166789178437745e2,
                                    1.9715909503065514427e3, 1.3731693765509461125e4,
                                    4.5921953931549871457e4, 6.7265770927008700853e4,
                                    3.3430575583588128105e4, 2.5090809287301226727e3};
constexpr double kMiddleBelow[7] = {4.2313330701600911252e1, 6.8718700749205790830e2,
                                    5.3941960214247511077e3, 2.1213794301586595867e4,
                                    3.9307895800092710610e4, 2.8729085735721942674e4,
                                    5.2264952788528545610e3};
// Coefficients of the tails, with r = sqrt(-ln p): in r - 1.6 for r <= 5, in r - 5 beyond.
constexpr double kNearAbove[8] = {1.42343711074968357734e0,  4.63033784615654529590e0,
                                  5.76949722146069140550e0,  3.64784832476320460504e0,
                                  1.27045825245236838258e0,  2.41780725177450611770e-1,
                                  2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr double kNearBelow[7] = {2.05319162663775882187e0,  1.67638483018380384940e0,
                                  6.89767334985100004550e-1, 1.48103976427480074590e-1,
                                  1.51986665636164571966e-2, 5.47593808499534494600e-4,
                                  1.05075007164441684324e-9};
constexpr double kFarAbove[8] = {6.65790464350110377720e0,  5.46378491116411436990e0,
                                 1.78482653991729133580e0,  2.96560571828504891230e-1,
                                 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                 2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr double kFarBelow[7] = {5.99832206555887937690e-1, 1.36929880922735805310e-1,
                                 1.48753612908506148525e-2, 7.86869131145613259100e-4,
                                 1.84631831751005468180e-5, 1.42151175831644588870e-7,
                                 2.04426310338993978564e-15};

}  // namespace detail

/// The quantile of p: a standard normal variable lies below it with probability p. -infinity at 0,
/// infinity at 1.
/// @param p  0 <= p <= 1
template <class Real>
SKYBODY_INLINE Real normal_quantile(const Real& p) {
  const Real q = p - 0.5;
  const Real middle =
      q * detail::rational_7(Real(0.180625) - q * q, detail::kMiddleAbove, detail::kMiddleBelow);
  const auto is_middle = abs(q) <= 0.425;
  if (all(is_middle)) return middle;
  const Real tail = min(p, 1.0 - p);
  const Real r = sqrt(-log(select(is_middle, Real(0.25), tail)));
  const Real near = detail::rational_7(r - 1.6, detail::kNearAbove, detail::kNearBelow);
  const Real far = detail::rational_7(r - 5.0, detail::kFarAbove, detail::kFarBelow);
  const Real out = select(r <= 5.0, near, select(tail > 0.0, far, Real(kInfinity)));
  return select(is_middle, middle, select(q < 0.0, -out, out));
}

/// The probability that a standard normal variable is below x: the inverse of normal_quantile() by
/// bisection, so that both agree, with the same bits on every machine. Slow: for set-up only.
inline double normal_cdf(double x) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 1100 && low < high; ++k) {
    const double middle = low + 0.5 * (high - low);
    if (middle == low || middle == high) break;
    (normal_quantile(middle) < x ? low : high) = middle;
  }
  return high == 1.0 && low > 0.5 && normal_quantile(low) < x ? 1.0 : low;
}

}  // namespace skybody
