// 3x3 matrices on Real: general (rotations) and symmetric (inertia). Sums run from left to right.
#pragma once

#include "core/base/math/vec3.h"

namespace skybody {

/// A 3x3 matrix, row-major: element (row, column) is m[3 row + column].
template <class Real>
struct Mat3 {
  Real m[9];

  SKYBODY_INLINE Real& operator()(int row, int column) { return m[3 * row + column]; }
  SKYBODY_INLINE const Real& operator()(int row, int column) const { return m[3 * row + column]; }

  static SKYBODY_INLINE Mat3 identity() {
    return {{Real(1.0), Real(0.0), Real(0.0), Real(0.0), Real(1.0), Real(0.0), Real(0.0), Real(0.0),
             Real(1.0)}};
  }
  SKYBODY_INLINE Vec3<Real> row(int i) const { return {m[3 * i], m[3 * i + 1], m[3 * i + 2]}; }
  SKYBODY_INLINE Vec3<Real> column(int i) const { return {m[i], m[3 + i], m[6 + i]}; }

  friend SKYBODY_INLINE Vec3<Real> operator*(const Mat3& a, const Vec3<Real>& v) {
    return {dot(a.row(0), v), dot(a.row(1), v), dot(a.row(2), v)};
  }
  friend SKYBODY_INLINE Mat3 operator*(const Mat3& a, const Mat3& b) {
    const Vec3<Real> c0 = a * b.column(0), c1 = a * b.column(1), c2 = a * b.column(2);
    return {{c0.x, c1.x, c2.x, c0.y, c1.y, c2.y, c0.z, c1.z, c2.z}};
  }
  friend SKYBODY_INLINE Mat3 operator+(const Mat3& a, const Mat3& b) {
    return {{a.m[0] + b.m[0], a.m[1] + b.m[1], a.m[2] + b.m[2], a.m[3] + b.m[3], a.m[4] + b.m[4],
             a.m[5] + b.m[5], a.m[6] + b.m[6], a.m[7] + b.m[7], a.m[8] + b.m[8]}};
  }
  friend SKYBODY_INLINE Mat3 operator-(const Mat3& a, const Mat3& b) {
    return {{a.m[0] - b.m[0], a.m[1] - b.m[1], a.m[2] - b.m[2], a.m[3] - b.m[3], a.m[4] - b.m[4],
             a.m[5] - b.m[5], a.m[6] - b.m[6], a.m[7] - b.m[7], a.m[8] - b.m[8]}};
  }
  friend SKYBODY_INLINE Mat3 operator*(const Mat3& a, const Real& s) {
    return {{a.m[0] * s, a.m[1] * s, a.m[2] * s, a.m[3] * s, a.m[4] * s, a.m[5] * s, a.m[6] * s,
             a.m[7] * s, a.m[8] * s}};
  }
};

template <class Real>
SKYBODY_INLINE Mat3<Real> transpose(const Mat3<Real>& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}

/// transpose(a) v without forming the transpose.
template <class Real>
SKYBODY_INLINE Vec3<Real> transpose_times(const Mat3<Real>& a, const Vec3<Real>& v) {
  return {dot(a.column(0), v), dot(a.column(1), v), dot(a.column(2), v)};
}

/// The matrix with skew(a) b = cross(a, b).
template <class Real>
SKYBODY_INLINE Mat3<Real> skew(const Vec3<Real>& a) {
  return {{Real(0.0), -a.z, a.y, a.z, Real(0.0), -a.x, -a.y, a.x, Real(0.0)}};
}

/// A symmetric 3x3 matrix. As an inertia: xx, yy, zz are the moments and xy, xz, yz the matrix's
/// off-diagonal elements (minus the integrals of x y dm: URDF's convention) [kg m^2].
template <class Real>
struct SymMat3 {
  Real xx, yy, zz, xy, xz, yz;

  friend SKYBODY_INLINE Vec3<Real> operator*(const SymMat3& a, const Vec3<Real>& v) {
    return {(a.xx * v.x + a.xy * v.y) + a.xz * v.z, (a.xy * v.x + a.yy * v.y) + a.yz * v.z,
            (a.xz * v.x + a.yz * v.y) + a.zz * v.z};
  }
  friend SKYBODY_INLINE SymMat3 operator+(const SymMat3& a, const SymMat3& b) {
    return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
  }
  friend SKYBODY_INLINE SymMat3 operator-(const SymMat3& a, const SymMat3& b) {
    return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.xz - b.xz, a.yz - b.yz};
  }
  friend SKYBODY_INLINE SymMat3 operator*(const SymMat3& a, const Real& s) {
    return {a.xx * s, a.yy * s, a.zz * s, a.xy * s, a.xz * s, a.yz * s};
  }
};

template <class Real>
SKYBODY_INLINE Mat3<Real> to_mat3(const SymMat3<Real>& a) {
  return {{a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz}};
}

/// The upper triangle of a matrix that is symmetric except for round-off.
template <class Real>
SKYBODY_INLINE SymMat3<Real> upper_triangle(const Mat3<Real>& a) {
  return {a.m[0], a.m[4], a.m[8], a.m[1], a.m[2], a.m[5]};
}

/// r a transpose(r): the same inertia on axes turned by the rotation r.
template <class Real>
SKYBODY_INLINE SymMat3<Real> rotate_inertia(const Mat3<Real>& r, const SymMat3<Real>& a) {
  const Vec3<Real> r0 = r.row(0), r1 = r.row(1), r2 = r.row(2);
  const Vec3<Real> a0 = a * r0, a1 = a * r1, a2 = a * r2;
  return {dot(r0, a0), dot(r1, a1), dot(r2, a2), dot(r0, a1), dot(r0, a2), dot(r1, a2)};
}

/// The parallel-axis term: inertia of a point of `mass` at `offset` from the reference point
/// [kg m^2].
template <class Real>
SKYBODY_INLINE SymMat3<Real> point_inertia(const Real& mass, const Vec3<Real>& offset) {
  const Real x2 = offset.x * offset.x, y2 = offset.y * offset.y, z2 = offset.z * offset.z;
  return {mass * (y2 + z2),
          mass * (x2 + z2),
          mass * (x2 + y2),
          -(mass * offset.x * offset.y),
          -(mass * offset.x * offset.z),
          -(mass * offset.y * offset.z)};
}

template <class Real>
SKYBODY_INLINE Real determinant(const SymMat3<Real>& a) {
  return (a.xx * (a.yy * a.zz - a.yz * a.yz) + a.xy * (a.yz * a.xz - a.xy * a.zz)) +
         a.xz * (a.xy * a.yz - a.yy * a.xz);
}

template <class Real>
SKYBODY_INLINE Real determinant(const Mat3<Real>& a) {
  return dot(a.row(0), cross(a.row(1), a.row(2)));
}

/// The inverse by cofactors; not finite if the matrix is singular.
template <class Real>
SKYBODY_INLINE SymMat3<Real> inverse(const SymMat3<Real>& a) {
  const Real c_xx = a.yy * a.zz - a.yz * a.yz;
  const Real c_xy = a.yz * a.xz - a.xy * a.zz;
  const Real c_xz = a.xy * a.yz - a.yy * a.xz;
  const Real scale = 1.0 / ((a.xx * c_xx + a.xy * c_xy) + a.xz * c_xz);
  return {c_xx * scale,
          (a.xx * a.zz - a.xz * a.xz) * scale,
          (a.xx * a.yy - a.xy * a.xy) * scale,
          c_xy * scale,
          c_xz * scale,
          (a.xy * a.xz - a.xx * a.yz) * scale};
}

/// The factorization L D L^T of a positive definite matrix, for solving; its accuracy is limited
/// only by the matrix's condition.
template <class Real>
class Ldl3 {
 public:
  SKYBODY_INLINE explicit Ldl3(const SymMat3<Real>& a) {
    inverse_x_ = 1.0 / a.xx;
    yx_ = a.xy * inverse_x_;
    zx_ = a.xz * inverse_x_;
    inverse_y_ = 1.0 / (a.yy - yx_ * a.xy);
    const Real zy = a.yz - yx_ * a.xz;
    zy_ = zy * inverse_y_;
    inverse_z_ = 1.0 / ((a.zz - zx_ * a.xz) - zy_ * zy);
  }
  /// Solves a x = b.
  SKYBODY_INLINE Vec3<Real> solve(const Vec3<Real>& b) const {
    const Real y = b.y - yx_ * b.x;
    const Real z = ((b.z - zx_ * b.x) - zy_ * y) * inverse_z_;
    const Real solved_y = y * inverse_y_ - zy_ * z;
    return {(b.x * inverse_x_ - yx_ * solved_y) - zx_ * z, solved_y, z};
  }

 private:
  Real inverse_x_, inverse_y_, inverse_z_;  ///< reciprocals of the diagonal D
  Real yx_, zx_, zy_;                       ///< entries of the unit lower triangle L
};

/// The inverse by cofactors; not finite if the matrix is singular.
template <class Real>
SKYBODY_INLINE Mat3<Real> inverse(const Mat3<Real>& a) {
  const Vec3<Real> c0 = cross(a.row(1), a.row(2));
  const Vec3<Real> c1 = cross(a.row(2), a.row(0));
  const Vec3<Real> c2 = cross(a.row(0), a.row(1));
  const Real s = 1.0 / dot(a.row(0), c0);
  return {
      {c0.x * s, c1.x * s, c2.x * s, c0.y * s, c1.y * s, c2.y * s, c0.z * s, c1.z * s, c2.z * s}};
}

}  // namespace skybody
