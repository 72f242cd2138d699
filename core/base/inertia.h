// Principal moments of an inertia matrix and whether a body can have it.
#pragma once

#include "core/base/mat3.h"

namespace skybody {
namespace detail {

/// One Jacobi rotation of a symmetric 3x3 matrix that makes a(p, q) zero.
/// Golub and Van Loan, Matrix Computations, section 8.5.
inline void jacobi_rotate(Mat3<double>& a, int p, int q) {
  const double off = a(p, q);
  if (off == 0.0) return;
  const double tau = (a(q, q) - a(p, p)) / (2.0 * off);
  const double t = copysign(1.0, tau) / (abs(tau) + sqrt(1.0 + tau * tau));
  const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
  const int r = 3 - p - q;
  const double rp = a(r, p), rq = a(r, q);
  a(p, p) -= t * off;
  a(q, q) += t * off;
  a(p, q) = a(q, p) = 0.0;
  a(r, p) = a(p, r) = c * rp - s * rq;
  a(r, q) = a(q, r) = s * rp + c * rq;
}

}  // namespace detail

/// Eigenvalues in ascending order, by eight sweeps of Jacobi rotations (which converge
/// quadratically; three or four reach the last bits). NaN in, unordered NaN out.
inline Vec3<double> eigenvalues(const SymMat3<double>& matrix) {
  Mat3<double> a = to_mat3(matrix);
  for (int sweep = 0; sweep < 8; ++sweep) {
    detail::jacobi_rotate(a, 0, 1);
    detail::jacobi_rotate(a, 0, 2);
    detail::jacobi_rotate(a, 1, 2);
  }
  double x = a(0, 0), y = a(1, 1), z = a(2, 2);
  const auto order = [](double& low, double& high) {
    if (high < low) {
      const double swap = low;
      low = high;
      high = swap;
    }
  };
  order(x, y);
  order(y, z);
  order(x, y);
  return {x, y, z};
}

/// Whether a rigid body can have this inertia about its centre of mass [kg m^2]: finite, positive
/// definite, and no principal moment above the sum of the other two (by more than `tolerance` of
/// it; rounded URDF values of flat bodies reach the bound).
inline bool is_physical_inertia(const SymMat3<double>& inertia, double tolerance = 1e-6) {
  const Vec3<double> moments = eigenvalues(inertia);
  return is_finite(moments) && moments.x > 0.0 &&
         moments.z <= (moments.x + moments.y) * (1.0 + tolerance);
}

}  // namespace skybody
