// Jets: a value with its derivatives by one variable, such as time. With Jet as Real, a closed form
// yields higher derivatives: of a path given as a formula of time, or of an attitude given by an
// acceleration.
//
// Only the operations of such formulas are here: sums, products, quotients, roots, sines. There are
// no comparisons: the caller chooses a formula's branch.
//
// Source of the recurrences: A. Griewank and A. Walther, Evaluating Derivatives, 2nd edition, 2008,
// tables 13.1 and 13.2.
#pragma once

#include "core/base/math/math.h"

namespace skybody {

/// Coefficients of a Taylor polynomial: c[k] is the k-th derivative divided by k!.
/// @tparam R  double, Pack<W>, or a Dual of these
/// @tparam N  number of coefficients, so derivatives up to N - 1
template <class R, int N>
struct Jet {
  R c[N];

  Jet() = default;
  /// A constant.
  SKYBODY_INLINE explicit Jet(double constant) {
    c[0] = R(constant);
    for (int k = 1; k < N; ++k) c[k] = R(0.0);
  }
  /// value + rate t.
  SKYBODY_INLINE static Jet variable(const R& value, const R& rate) {
    Jet jet(0.0);
    jet.c[0] = value;
    if (N > 1) jet.c[1] = rate;
    return jet;
  }

  /// The k-th derivative.
  SKYBODY_INLINE R derivative(int k) const {
    double factorial = 1.0;
    for (int i = 2; i <= k; ++i) factorial *= i;
    return c[k] * factorial;
  }

  friend SKYBODY_INLINE Jet operator-(const Jet& a) {
    Jet out;
    for (int k = 0; k < N; ++k) out.c[k] = -a.c[k];
    return out;
  }
  friend SKYBODY_INLINE Jet operator+(const Jet& a, const Jet& b) {
    Jet out;
    for (int k = 0; k < N; ++k) out.c[k] = a.c[k] + b.c[k];
    return out;
  }
  friend SKYBODY_INLINE Jet operator-(const Jet& a, const Jet& b) {
    Jet out;
    for (int k = 0; k < N; ++k) out.c[k] = a.c[k] - b.c[k];
    return out;
  }
  friend SKYBODY_INLINE Jet operator*(const Jet& a, const Jet& b) {
    Jet out;
    for (int k = 0; k < N; ++k) {
      R sum = a.c[0] * b.c[k];
      for (int i = 1; i <= k; ++i) sum = sum + a.c[i] * b.c[k - i];
      out.c[k] = sum;
    }
    return out;
  }
  friend SKYBODY_INLINE Jet operator/(const Jet& a, const Jet& b) {
    Jet out;
    const R inverse = 1.0 / b.c[0];
    for (int k = 0; k < N; ++k) {
      R rest = a.c[k];
      for (int i = 0; i < k; ++i) rest = rest - out.c[i] * b.c[k - i];
      out.c[k] = rest * inverse;
    }
    return out;
  }

  friend SKYBODY_INLINE Jet operator+(const Jet& a, double b) {
    Jet out = a;
    out.c[0] = a.c[0] + b;
    return out;
  }
  friend SKYBODY_INLINE Jet operator+(double a, const Jet& b) { return b + a; }
  friend SKYBODY_INLINE Jet operator-(const Jet& a, double b) { return a + (-b); }
  friend SKYBODY_INLINE Jet operator-(double a, const Jet& b) { return -b + a; }
  friend SKYBODY_INLINE Jet operator*(const Jet& a, double b) {
    Jet out;
    for (int k = 0; k < N; ++k) out.c[k] = a.c[k] * b;
    return out;
  }
  friend SKYBODY_INLINE Jet operator*(double a, const Jet& b) { return b * a; }
  /// The product with a constant factor.
  friend SKYBODY_INLINE Jet scaled(const Jet& a, const R& b) {
    Jet out;
    for (int k = 0; k < N; ++k) out.c[k] = a.c[k] * b;
    return out;
  }
  friend SKYBODY_INLINE Jet operator/(double a, const Jet& b) { return Jet(a) / b; }

  /// The square root; the value must be above 0.
  friend SKYBODY_INLINE Jet sqrt(const Jet& a) {
    Jet out;
    out.c[0] = sqrt(a.c[0]);
    const R inverse = 0.5 / out.c[0];
    for (int k = 1; k < N; ++k) {
      R rest = a.c[k];
      for (int i = 1; i < k; ++i) rest = rest - out.c[i] * out.c[k - i];
      out.c[k] = rest * inverse;
    }
    return out;
  }
};

template <class R, int N>
SKYBODY_INLINE SinCos<Jet<R, N>> sincos(const Jet<R, N>& a) {
  SinCos<Jet<R, N>> out;
  const SinCos<R> first = sincos(a.c[0]);
  out.sin.c[0] = first.sin;
  out.cos.c[0] = first.cos;
  for (int k = 1; k < N; ++k) {
    R sine = a.c[1] * out.cos.c[k - 1], cosine = a.c[1] * out.sin.c[k - 1];
    for (int i = 2; i <= k; ++i) {
      sine = sine + (a.c[i] * static_cast<double>(i)) * out.cos.c[k - i];
      cosine = cosine + (a.c[i] * static_cast<double>(i)) * out.sin.c[k - i];
    }
    out.sin.c[k] = sine * (1.0 / k);
    out.cos.c[k] = -cosine * (1.0 / k);
  }
  return out;
}

}  // namespace skybody
