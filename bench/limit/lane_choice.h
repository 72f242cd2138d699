// Choices per lane as one machine instruction each, on double and packs. The same bits as select()
// and max() of core/base.
#pragma once

#include "core/base/math.h"

namespace skybody::bench::limit {

/// a where the mask is set, else b.
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

/// atan2(y, x) for x > 0 and finite y; else some finite value. As core/base/math_atan.h without
/// what only zeros, infinities and the left half plane need.
template <class Real>
SKYBODY_INLINE Real atan2_right(const Real& y, const Real& x) {
  const Real ay = abs(y);
  const auto steep = ay > x;
  const Real den = larger(ay, x), num = smaller(ay, x);
  const auto shifted = num > 0.41421356237309503 * den;
  const Real ratio = pick(shifted, num - den, num) / pick(shifted, num + den, den);
  const Real core = skybody::detail::atan_kernel(ratio);
  const Real first = pick(shifted, Real(kQuarterPi), Real(0.0)) + core;
  return copysign(pick(steep, kHalfPi - first, first), y);
}

}  // namespace skybody::bench::limit
