#include "controllers/lqr/riccati.h"

#include <Eigen/LU>
#include <cmath>

#include "plugins/api/refuse.h"

namespace skybody::control {
namespace {

using Matrix = Eigen::MatrixXd;

/// E, G, H of the doubling algorithm: H converges to the solution.
struct Doubling {
  Matrix e, g, h;

  /// Cayley transform: maps stable eigenvalues into the unit circle. Any `shift` above 0 is valid;
  /// a value near the eigenvalues' magnitude needs the fewest steps.
  Doubling(const Matrix& a, const Matrix& input, const Matrix& q, double shift) {
    const Matrix one = Matrix::Identity(a.rows(), a.cols());
    const Matrix shifted = a - shift * one, inverse = shifted.inverse();
    const Matrix w = (shifted + input * inverse.transpose() * q).inverse();
    const Matrix v = (shifted.transpose() + q * inverse * input).inverse();
    e = one + 2.0 * shift * w;
    g = 2.0 * shift * inverse * input * v;
    h = 2.0 * shift * v * q * inverse;
  }

  /// @returns the relative change of h
  double step() {
    const Matrix one = Matrix::Identity(e.rows(), e.cols());
    const Matrix middle = (one + g * h).inverse();
    const Matrix change = e.transpose() * h * middle * e;
    g += (e * middle * g * e.transpose()).eval();
    h += change;
    e = (e * middle * e).eval();
    return change.cwiseAbs().maxCoeff() / h.cwiseAbs().maxCoeff();
  }
};

constexpr int kMostSteps = 60;  // each step squares the spectral radius
constexpr double kShift = 3.0;  // 1/s: magnitude of a vehicle's eigenvalues

}  // namespace

Matrix solve_riccati(const Matrix& a, const Matrix& b, const Matrix& q, const Matrix& r) {
  Doubling doubling(a, b * r.inverse() * b.transpose(), q, kShift);
  for (int i = 0; i < kMostSteps; ++i) {
    const double change = doubling.step();
    if (!std::isfinite(change)) break;
    if (change < 1e-15) return 0.5 * (doubling.h + doubling.h.transpose());
  }
  refuse(
      "the Riccati equation of these weights has no solution that can be found: weights of "
      "positions and attitudes must be above 0 and of sizes that are nearer to one another");
}

Matrix regulator_gain(const Matrix& a, const Matrix& b, const Matrix& q, const Matrix& r) {
  return r.inverse() * b.transpose() * solve_riccati(a, b, q, r);
}

Eigen::VectorXd chain_gain(const std::vector<double>& steps, const std::vector<double>& weights,
                           double input_weight) {
  const auto n = static_cast<Eigen::Index>(weights.size());
  Matrix a = Matrix::Zero(n, n), b = Matrix::Zero(n, 1), q = Matrix::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) q(i, i) = weights[static_cast<std::size_t>(i)];
  for (Eigen::Index i = 0; i + 1 < n; ++i) a(i, i + 1) = steps[static_cast<std::size_t>(i)];
  b(n - 1, 0) = 1.0;
  return regulator_gain(a, b, q, Matrix::Constant(1, 1, input_weight)).transpose();
}

}  // namespace skybody::control
