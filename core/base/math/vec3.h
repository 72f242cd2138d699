// Vectors of three components on Real. Sums run x, y, z from left to right.
#pragma once

#include "core/base/math/math_basic.h"

namespace skybody {

/// A vector of three components; its owner defines unit and frame.
template <class Real>
struct Vec3 {
  Real x, y, z;

  SKYBODY_INLINE Vec3& operator+=(const Vec3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  SKYBODY_INLINE Vec3& operator-=(const Vec3& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
  SKYBODY_INLINE Vec3& operator*=(const Real& s) {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }

  friend SKYBODY_INLINE Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend SKYBODY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend SKYBODY_INLINE Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend SKYBODY_INLINE Vec3 operator*(const Vec3& a, const Real& s) {
    return {a.x * s, a.y * s, a.z * s};
  }
  friend SKYBODY_INLINE Vec3 operator*(const Real& s, const Vec3& a) {
    return {a.x * s, a.y * s, a.z * s};
  }
  /// Three divisions: a / s rounds differently from a * (1 / s).
  friend SKYBODY_INLINE Vec3 operator/(const Vec3& a, const Real& s) {
    return {a.x / s, a.y / s, a.z / s};
  }
};

/// (a.x b.x + a.y b.y) + a.z b.z
template <class Real>
SKYBODY_INLINE Real dot(const Vec3<Real>& a, const Vec3<Real>& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

template <class Real>
SKYBODY_INLINE Vec3<Real> cross(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Product component by component.
template <class Real>
SKYBODY_INLINE Vec3<Real> multiply_elements(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

template <class Real>
SKYBODY_INLINE Real squared_norm(const Vec3<Real>& a) {
  return dot(a, a);
}
template <class Real>
SKYBODY_INLINE Real norm(const Vec3<Real>& a) {
  return sqrt(dot(a, a));
}

/// a where the mask is set, else b.
template <class Real>
SKYBODY_INLINE Vec3<Real> select(const MaskOf<Real>& mask, const Vec3<Real>& a,
                                 const Vec3<Real>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
template <class Real>
SKYBODY_INLINE Vec3<Real> choose(const MaskOf<Real>& mask, const Vec3<Real>& a,
                                 const Vec3<Real>& b) {
  return {choose(mask, a.x, b.x), choose(mask, a.y, b.y), choose(mask, a.z, b.z)};
}

/// Whether any component is not zero.
template <class Real>
SKYBODY_INLINE MaskOf<Real> is_not_zero(const Vec3<Real>& a) {
  return logical_or(logical_or(a.x != 0.0, a.y != 0.0), a.z != 0.0);
}

/// Whether all three components are finite.
template <class Real>
SKYBODY_INLINE MaskOf<Real> is_finite(const Vec3<Real>& a) {
  return logical_and(logical_and(is_finite(a.x), is_finite(a.y)), is_finite(a.z));
}

/// The same vector for all lanes.
template <class Real>
SKYBODY_INLINE Vec3<Real> to_real(const Vec3<double>& v) {
  return {Real(v.x), Real(v.y), Real(v.z)};
}

}  // namespace skybody
