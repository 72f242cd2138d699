// Drawn inertias are checked at resets, between the files and the hash: Eigen must add in one order
// whatever the instruction set, so that its vector code is left out here.
#define EIGEN_DONT_VECTORIZE
#include "core/base/inertia.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace skybody {

Vec3<double> eigenvalues(const SymMat3<double>& matrix) {
  const Mat3<double> m = to_mat3(matrix);
  Eigen::Matrix3d a;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) a(row, column) = m(row, column);
  }
  if (!a.allFinite()) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan, nan};
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d& moments = solver.eigenvalues();
  return {moments.x(), moments.y(), moments.z()};
}

bool is_physical_inertia(const SymMat3<double>& inertia, double tolerance) {
  const Vec3<double> moments = eigenvalues(inertia);
  return is_finite(moments) && moments.x > 0.0 &&
         moments.z <= (moments.x + moments.y) * (1.0 + tolerance);
}

}  // namespace skybody
