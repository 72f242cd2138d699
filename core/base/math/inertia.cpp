// Drawn inertias are checked at resets, so the result reaches the hash. Eigen's vector code is
// disabled: it would add in an order that depends on the instruction set.
#define EIGEN_DONT_VECTORIZE
#include "core/base/math/inertia.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

namespace skybody {

namespace {

constexpr double kLeastRatio = 1e-3;   // least repaired principal moment, relative to the largest
constexpr double kLeastRadius = 1e-3;  // least radius of gyration of a repaired inertia [m]

Eigen::Matrix3d to_eigen(const SymMat3<double>& matrix) {
  const Mat3<double> m = to_mat3(matrix);
  Eigen::Matrix3d a;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) a(row, column) = m(row, column);
  }
  return a;
}

}  // namespace

Vec3<double> eigenvalues(const SymMat3<double>& matrix) {
  const Eigen::Matrix3d a = to_eigen(matrix);
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

SymMat3<double> repaired_inertia(const SymMat3<double>& inertia, double mass) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(to_eigen(inertia));
  Eigen::Vector3d moments = solver.eigenvalues();  // ascending
  const double least = std::max(kLeastRatio * moments.z(), mass * (kLeastRadius * kLeastRadius));
  moments = moments.cwiseMax(least);
  moments.z() = std::min(moments.z(), moments.x() + moments.y());
  const Eigen::Matrix3d axes = solver.eigenvectors();
  const Eigen::Matrix3d a = axes * moments.asDiagonal() * axes.transpose();
  return {a(0, 0), a(1, 1), a(2, 2), a(0, 1), a(0, 2), a(1, 2)};
}

}  // namespace skybody
