// Dual numbers: a value and its derivative along one direction (the tangent), for forward-mode
// differentiation.
//
// Code that is a template on Real also runs on Dual<double> and Dual<Pack<W>>. The value has the
// same bits as a computation in R: the operations are the same, and comparisons use values alone.
// The tangent follows by the chain rule: if the inputs' tangents are a direction, the outputs'
// tangents are the directional derivative. Constants and random numbers have the tangent 0.
//
// Where a function has no derivative:
//   - `select`, `abs`, `min`, `max` and `clamp` have the tangent of the branch taken;
//   - `floor` and `round_half_even` have the tangent 0 everywhere;
//   - sqrt(0), and therefore the norm of a zero vector, and atan2(0, 0) have the tangent 0.
#pragma once

#include <type_traits>

#include "core/base/math/math.h"

namespace skybody {

/// A value and its tangent. R: double or Pack<W>.
template <class R>
struct Dual {
  R value;
  R tangent;

  Dual() = default;
  /// A constant.
  SKYBODY_INLINE Dual(double constant) : value(constant), tangent(0.0) {}
  struct NoOtherType {};
  using Other = std::conditional_t<std::is_same<R, double>::value, NoOtherType, R>;
  /// A constant pack, such as times and random numbers.
  SKYBODY_INLINE Dual(const Other& constant) : value(constant), tangent(0.0) {}
  SKYBODY_INLINE Dual(const R& value_part, const R& tangent_part)
      : value(value_part), tangent(tangent_part) {}

  friend SKYBODY_INLINE Dual operator+(const Dual& a) { return a; }
  friend SKYBODY_INLINE Dual operator-(const Dual& a) { return {-a.value, -a.tangent}; }
  friend SKYBODY_INLINE Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.tangent + b.tangent};
  }
  friend SKYBODY_INLINE Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.tangent - b.tangent};
  }
  friend SKYBODY_INLINE Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.tangent * b.value + a.value * b.tangent};
  }
  friend SKYBODY_INLINE Dual operator/(const Dual& a, const Dual& b) {
    const R quotient = a.value / b.value;
    return {quotient, (a.tangent - quotient * b.tangent) / b.value};
  }
  // Operations with constants avoid products with a zero tangent: 0 times infinity is NaN.
#define SKYBODY_DUAL_CONSTANT(Type)                                    \
  friend SKYBODY_INLINE Dual operator+(const Dual& a, const Type& b) { \
    return {a.value + b, a.tangent};                                   \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator+(const Type& a, const Dual& b) { \
    return {a + b.value, b.tangent};                                   \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator-(const Dual& a, const Type& b) { \
    return {a.value - b, a.tangent};                                   \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator-(const Type& a, const Dual& b) { \
    return {a - b.value, -b.tangent};                                  \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator*(const Dual& a, const Type& b) { \
    return {a.value * b, a.tangent * b};                               \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator*(const Type& a, const Dual& b) { \
    return {a * b.value, a * b.tangent};                               \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator/(const Dual& a, const Type& b) { \
    return {a.value / b, a.tangent / b};                               \
  }                                                                    \
  friend SKYBODY_INLINE Dual operator/(const Type& a, const Dual& b) { \
    const R quotient = a / b.value;                                    \
    return {quotient, -(quotient * b.tangent) / b.value};              \
  }
  SKYBODY_DUAL_CONSTANT(double)
  SKYBODY_DUAL_CONSTANT(Other)
#undef SKYBODY_DUAL_CONSTANT

#define SKYBODY_DUAL_ASSIGNMENT(op)                                                 \
  SKYBODY_INLINE Dual& operator op##=(const Dual& b) { return *this = *this op b; } \
  SKYBODY_INLINE Dual& operator op##=(double b) { return *this = *this op b; }
  SKYBODY_DUAL_ASSIGNMENT(+)
  SKYBODY_DUAL_ASSIGNMENT(-)
  SKYBODY_DUAL_ASSIGNMENT(*)
  SKYBODY_DUAL_ASSIGNMENT(/)
#undef SKYBODY_DUAL_ASSIGNMENT

#define SKYBODY_DUAL_COMPARISON(op)                                           \
  friend SKYBODY_INLINE MaskOf<R> operator op(const Dual& a, const Dual& b) { \
    return a.value op b.value;                                                \
  }
  SKYBODY_DUAL_COMPARISON(==)
  SKYBODY_DUAL_COMPARISON(!=)
  SKYBODY_DUAL_COMPARISON(<)
  SKYBODY_DUAL_COMPARISON(>)
  SKYBODY_DUAL_COMPARISON(<=)
  SKYBODY_DUAL_COMPARISON(>=)
#undef SKYBODY_DUAL_COMPARISON

  /// Per lane: a where the mask is set, else b.
  friend SKYBODY_INLINE Dual select(const MaskOf<R>& mask, const Dual& a, const Dual& b) {
    return choose(mask, a, b);
  }
  friend SKYBODY_INLINE Dual choose(const MaskOf<R>& mask, const Dual& a, const Dual& b) {
    return {skybody::choose(mask, a.value, b.value), skybody::choose(mask, a.tangent, b.tangent)};
  }
};

template <class>
inline constexpr bool kIsDual = false;
template <class R>
inline constexpr bool kIsDual<Dual<R>> = true;

template <class R>
struct RealTraits<Dual<R>> {
  using Mask = MaskOf<R>;
  using Word = skybody::Word<R>;
  static constexpr int kLanes = kLanesOf<R>;
};

namespace detail {
template <class Real>
struct ValueOf {
  using type = Real;
  static constexpr int kRows = 1;
};
template <class R>
struct ValueOf<Dual<R>> {
  using type = R;
  static constexpr int kRows = 2;
};
}  // namespace detail

/// R of a Dual<R>; double and Pack<W> themselves.
template <class Real>
using ValueOf = typename detail::ValueOf<Real>::type;
/// Rows of memory per value: 2 for dual numbers (the value, then the tangent), else 1.
template <class Real>
constexpr int kRowsOf = detail::ValueOf<Real>::kRows;

/// Reads the lanes of one value from its rows, which are `stride` doubles apart.
template <class Real>
SKYBODY_INLINE Real load_rows(const double* p, std::size_t stride) {
  if constexpr (kRowsOf<Real> == 2) {
    return {load_lanes<ValueOf<Real>>(p), load_lanes<ValueOf<Real>>(p + stride)};
  } else {
    return load_lanes<Real>(p);
  }
}
/// Writes the lanes of one value to its rows where the mask is set.
template <class Real>
SKYBODY_INLINE void store_rows(double* p, std::size_t stride, const Real& x,
                               const MaskOf<Real>& mask) {
  if constexpr (kRowsOf<Real> == 2) {
    store_lanes(p, x.value, mask);
    store_lanes(p + stride, x.tangent, mask);
  } else {
    store_lanes(p, x, mask);
  }
}

/// Whole numbers 0 <= x < 2^52 as words, exactly.
template <class R>
SKYBODY_INLINE Word<R> to_word(const Dual<R>& x) {
  return to_word(x.value);
}

// math_basic.h: functions on bits. The other functions are templates that accept dual numbers.

template <class R>
SKYBODY_INLINE Dual<R> sqrt(const Dual<R>& x) {
  const R root = sqrt(x.value);
  return {root, select(root == 0.0, R(0.0), x.tangent / (root + root))};
}
/// The magnitude of x with the sign of `sign`. The tangent changes sign where the value does.
template <class R>
SKYBODY_INLINE Dual<R> copysign(const Dual<R>& x, const Dual<R>& sign) {
  const Word<R> turned = (bit_cast_word(x.value) ^ bit_cast_word(sign.value)) & detail::kSignBit;
  return {copysign(x.value, sign.value), bit_cast_real(bit_cast_word(x.tangent) ^ turned)};
}
template <class R>
SKYBODY_INLINE Dual<R> copysign(const Dual<R>& x, double sign) {
  return copysign(x, Dual<R>(sign));
}
template <class R>
SKYBODY_INLINE Dual<R> copysign(double x, const Dual<R>& sign) {
  return copysign(Dual<R>(x), sign);
}
template <class R>
SKYBODY_INLINE Dual<R> abs(const Dual<R>& x) {
  return copysign(x, Dual<R>(0.0));
}
template <class R>
SKYBODY_INLINE Dual<R> round_half_even(const Dual<R>& x) {
  return Dual<R>(round_half_even(x.value), R(0.0));
}
template <class R>
SKYBODY_INLINE Dual<R> floor(const Dual<R>& x) {
  return Dual<R>(floor(x.value), R(0.0));
}

/// Mixed overloads, as for packs.
template <class R>
SKYBODY_INLINE Dual<R> min(const Dual<R>& a, double b) {
  return min(a, Dual<R>(b));
}
template <class R>
SKYBODY_INLINE Dual<R> min(double a, const Dual<R>& b) {
  return min(Dual<R>(a), b);
}
template <class R>
SKYBODY_INLINE Dual<R> max(const Dual<R>& a, double b) {
  return max(a, Dual<R>(b));
}
template <class R>
SKYBODY_INLINE Dual<R> max(double a, const Dual<R>& b) {
  return max(Dual<R>(a), b);
}
template <class R>
SKYBODY_INLINE Dual<R> clamp(const Dual<R>& x, double low, double high) {
  return clamp(x, Dual<R>(low), Dual<R>(high));
}

// math_exp.h

template <class R>
SKYBODY_INLINE Dual<R> exp(const Dual<R>& x) {
  const R value = exp(x.value);
  return {value, value * x.tangent};
}
template <class R>
SKYBODY_INLINE Dual<R> expm1(const Dual<R>& x) {
  return {expm1(x.value), exp(x.value) * x.tangent};
}
template <class R>
SKYBODY_INLINE Dual<R> log(const Dual<R>& x) {
  return {log(x.value), x.tangent / x.value};
}

// math_trig.h; sin, cos and tan call this function.

template <class R>
SKYBODY_INLINE SinCos<Dual<R>> sincos(const Dual<R>& x) {
  const SinCos<R> value = sincos(x.value);
  return {{value.sin, value.cos * x.tangent}, {value.cos, -(value.sin * x.tangent)}};
}
template <class R>
SKYBODY_INLINE Dual<R> wrap_angle(const Dual<R>& x) {
  return {wrap_angle(x.value), x.tangent};
}

// math_atan.h; asin and acos call this function.

/// The tangent is valid for magnitudes between 1e-150 and 1e150; at (0, 0) it is 0.
template <class R>
SKYBODY_INLINE Dual<R> atan2(const Dual<R>& y, const Dual<R>& x) {
  const R square = x.value * x.value + y.value * y.value;
  const R turned = x.value * y.tangent - y.value * x.tangent;
  return {atan2(y.value, x.value), select(square == 0.0, R(0.0), turned / square)};
}

}  // namespace skybody
