// atan2, asin and acos on Real. See core/base/math/math.h.
#pragma once

#include "core/base/math/math_basic.h"

namespace skybody {
namespace detail {

/// atan(x) for |x| <= 7/16. Coefficients: fdlibm s_atan.c.
template <class Real>
SKYBODY_INLINE Real atan_kernel(const Real& x) {
  const Real z = x * x;
  const Real w = z * z;
  const Real v = w * w;
  // Four independent short sums, for instruction-level parallelism.
  const Real even = polynomial(v, 3.33333333333329318027e-01, 9.09088713343650656196e-02,
                               4.97687799461593236017e-02) +
                    w * polynomial(v, 1.42857142725034663711e-01, 6.66107313738753120669e-02,
                                   1.62858201153657823623e-02);
  const Real odd = polynomial(v, -1.99999999998764832476e-01, -7.69187620504482999495e-02,
                              -3.65315727442169155270e-02) +
                   w * polynomial(v, -1.11111104054623557880e-01, -5.83357013379057348645e-02);
  return x - x * (z * even + w * odd);
}

}  // namespace detail

/// The angle of the point (x, y) in [-pi, pi] [rad]. Error below 2.5 ulp. Zeros, infinities and
/// signs as in C's atan2; NaN if either is NaN. Method: the ratio in the first octant, shifted by
/// pi/4 above tan(pi/8), one division; fdlibm's series.
template <class Real>
SKYBODY_INLINE Real atan2(const Real& y, const Real& x) {
  using M = MaskOf<Real>;
  const Real ay = abs(y), ax = abs(x);
  const M steep = ay > ax;
  const Real larger = select(steep, ay, ax);
  const Real smaller = select(steep, ax, ay);
  // Keep sums finite and 0/0, inf/inf defined.
  const Real scale = select(larger > 1e300, Real(0.25), Real(1.0));
  const M same_infinity = smaller == kInfinity;
  const M has_ratio = logical_not(logical_or(same_infinity, larger == 0.0));
  const Real den = select(has_ratio, larger * scale, Real(1.0));
  const Real num = select(same_infinity, Real(1.0), smaller * scale);
  const M shifted = num > 0.41421356237309503 * den;
  const Real ratio = select(shifted, num - den, num) / select(shifted, num + den, den);
  const Real core = detail::atan_kernel(ratio);
  // angle = base + core in the first octant; then steep: pi/2 - angle; then left: pi - angle.
  const M left = bit_cast_word(x) >= Word<Real>(detail::kSignBit);
  const Real flipped = select(
      logical_or(logical_and(steep, logical_not(left)), logical_and(left, logical_not(steep))),
      -core, core);
  // base in units of pi/4: right: 0, 1 | steep 2, 1; left: 4, 3 | steep 2, 3.
  const Real base_high =
      select(shifted, select(left, Real(2.35619449019234483700e+00), Real(kQuarterPi)),
             select(steep, Real(kHalfPi), select(left, Real(kPi), Real(0.0))));
  const Real base_low = select(
      shifted, select(left, Real(9.18485099360514843750e-17), Real(3.06161699786838301793e-17)),
      select(steep, Real(6.12323399573676603587e-17),
             select(left, Real(1.22464679914735317723e-16), Real(0.0))));
  const Real angle = base_high + (flipped + base_low);
  const Real value = copysign(angle, y);
  return select(logical_or(is_nan(x), is_nan(y)), x + y, value);
}

/// The angle in [-pi/2, pi/2] [rad] whose sine is x, |x| <= 1; NaN beyond. Error below 3 ulp.
template <class Real>
SKYBODY_INLINE Real asin(const Real& x) {
  return atan2(x, sqrt((1.0 - x) * (1.0 + x)));
}

/// The angle in [0, pi] [rad] whose cosine is x, |x| <= 1; NaN beyond. Error below 3 ulp.
template <class Real>
SKYBODY_INLINE Real acos(const Real& x) {
  return atan2(sqrt((1.0 - x) * (1.0 + x)), x);
}

}  // namespace skybody
