// A point on a path with its derivatives, and the pace along the path.
//
// A path is a function p(s) of path time s [s]. A clock maps time t to path time: s(t). The
// derivatives of p(s(t)) by t follow from both by composing Taylor polynomials.
#pragma once

#include "core/base/math/jet.h"
#include "core/base/math/vec3.h"

namespace skybody::reference {

/// Coefficients of a reference: position and four derivatives.
inline constexpr int kOrders = 5;

/// A point with derivatives up to order N - 1. W axes [m].
template <class Real, int N = kOrders>
using PathPoint = Vec3<Jet<Real, N>>;

/// Derivative k of a point [m/s^k].
template <class Real, int N>
SKYBODY_INLINE Vec3<Real> derivative(const Vec3<Jet<Real, N>>& point, int k) {
  return {point.x.derivative(k), point.y.derivative(k), point.z.derivative(k)};
}

/// f(s(t)) from f about s(t0) and s about t0: Horner's rule on Taylor polynomials.
template <class Real, int N>
SKYBODY_INLINE Jet<Real, N> composed(const Jet<Real, N>& f, const Jet<Real, N>& s) {
  Jet<Real, N> step = s;
  step.c[0] = Real(0.0);
  Jet<Real, N> sum(0.0);
  sum.c[0] = f.c[N - 1];
  for (int k = N - 2; k >= 0; --k) {
    sum = sum * step;
    sum.c[0] = sum.c[0] + f.c[k];
  }
  return sum;
}

/// The same for each axis.
template <class Real, int N>
SKYBODY_INLINE Vec3<Jet<Real, N>> composed(const Vec3<Jet<Real, N>>& f, const Jet<Real, N>& s) {
  return {composed(f.x, s), composed(f.y, s), composed(f.z, s)};
}

/// The same for a constant pace, with the bits of composed() except where its results are -0.
template <class Real, int N>
SKYBODY_INLINE Jet<Real, N> paced(const Jet<Real, N>& f, const Real& pace) {
  Jet<Real, N> out;
  for (int k = 0; k < N; ++k) {
    out.c[k] = f.c[k];
    for (int i = 0; i < k; ++i) out.c[k] = out.c[k] * pace;
    out.c[k] = out.c[k] + 0.0;
  }
  return out;
}

/// A rise from 0 to 1 over `duration`. Four derivatives are zero at both ends, so that snap is
/// continuous: 126 x^5 - 420 x^6 + 540 x^7 - 315 x^8 + 70 x^9.
/// @param duration  [s], above 0
template <int N, class Real>
SKYBODY_INLINE Jet<Real, N> smooth_rise(const Real& time, double duration) {
  using Number = Jet<Real, N>;
  const Real share = clamp(time * (1.0 / duration), Real(0.0), Real(1.0));
  const auto x = Number::variable(share, Real(1.0 / duration));
  const Number square = x * x;
  const Number rise =
      square * square * x * ((((x * 70.0 + (-315.0)) * x + 540.0) * x + (-420.0)) * x + 126.0);
  const auto inside = logical_and(time > 0.0, time < duration);
  Number out = rise;
  for (int k = 1; k < N; ++k) out.c[k] = select(inside, rise.c[k], Real(0.0));
  return out;
}

/// Path time as a function of time: zero until `begin`, then with a pace that rises.
/// @tparam Real  double, a pack, or a Dual
template <class Real>
struct Clock {
  double begin;  ///< [s]
  double ramp;   ///< time in which the pace rises from 0 to its full value [s]; 0: immediately
  Real scale;    ///< path time per second, after the ramp

  /// Path time after the ramp.
  SKYBODY_INLINE Real steady(const Real& time) const {
    return ((time - begin) - 0.5 * ramp) * scale;
  }

  /// Path time at `time` [s]. During the ramp, with x its elapsed fraction, the pace is scale (35
  /// x^4 - 84 x^5 + 70 x^6 - 20 x^7), whose first three derivatives are zero at both ends. Its
  /// integral is scale ramp (7 x^5 - 14 x^6 + 10 x^7 - 2.5 x^8), which is scale ramp / 2 at the
  /// end.
  template <int N>
  SKYBODY_INLINE Jet<Real, N> at(const Real& time) const {
    using Number = Jet<Real, N>;
    const Real since = time - begin;
    Number out = scaled(Number::variable(since - 0.5 * ramp, Real(1.0)), scale);
    if (ramp > 0.0) {
      const Real share = clamp(since * (1.0 / ramp), Real(0.0), Real(1.0));
      const auto x = Number::variable(share, Real(1.0 / ramp));
      const Number square = x * x;
      const Number sum = square * square * x * (((x * -2.5 + 10.0) * x + (-14.0)) * x + 7.0) * ramp;
      const Number rising = scaled(sum, scale);
      const auto on = since < ramp;
      for (int k = 0; k < N; ++k) out.c[k] = select(on, rising.c[k], out.c[k]);
    }
    const auto has_begun = since >= 0.0;
    for (int k = 0; k < N; ++k) out.c[k] = select(has_begun, out.c[k], Real(0.0));
    return out;
  }
};

}  // namespace skybody::reference
