// Adjoints of operations on rotations. A value `x` has the adjoint `to_x`. On double and packs.
#pragma once

#include "core/base/math/quat.h"

namespace skybody {

/// Adjoint of to_mat3 (quat.h). @param to  adjoint of the matrix
template <class Real>
SKYBODY_INLINE Quat<Real> pull_back_axes(const Quat<Real>& q, const Mat3<Real>& to) {
  const auto& m = to.m;
  const Vec3<Real> skew{m[7] - m[5], m[2] - m[6], m[3] - m[1]};
  const Real xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
  const auto twice = [](const Real& a) { return a + a; };
  return {twice(q.x * skew.x + q.y * skew.y + q.z * skew.z),
          twice(q.w * skew.x + q.y * xy + q.z * xz - twice(q.x * (m[4] + m[8]))),
          twice(q.w * skew.y + q.x * xy + q.z * yz - twice(q.y * (m[0] + m[8]))),
          twice(q.w * skew.z + q.x * xz + q.y * yz - twice(q.z * (m[0] + m[4])))};
}

/// Sum by components.
template <class Real>
SKYBODY_INLINE Quat<Real> sum(const Quat<Real>& a, const Quat<Real>& b) {
  return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}

/// Adjoint of q / |q|, given the result. @param inverse_norm  1 / |q|
template <class Real>
SKYBODY_INLINE Quat<Real> pull_back_norm(const Quat<Real>& to, const Quat<Real>& unit,
                                         const Real& inverse_norm) {
  const Real along = to.w * unit.w + to.x * unit.x + to.y * unit.y + to.z * unit.z;
  return {(to.w - unit.w * along) * inverse_norm, (to.x - unit.x * along) * inverse_norm,
          (to.y - unit.y * along) * inverse_norm, (to.z - unit.z * along) * inverse_norm};
}

/// a b^T: the adjoint of the matrix in the product `matrix b`, with a the adjoint of the product.
template <class Real>
SKYBODY_INLINE Mat3<Real> outer(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {{a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y,
           a.z * b.z}};
}

}  // namespace skybody
