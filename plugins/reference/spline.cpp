#include "plugins/reference/spline.h"

#include <Eigen/Dense>

namespace skybody::reference {
namespace {

using Free = Eigen::Vector3d;  // velocity, acceleration and jerk at a knot
using Block = Eigen::Matrix3d;

/// A piece of duration h with value and derivatives (p, v, a, j) at both ends, in the basis 1, x,
/// ..., x^7. The values at the beginning give the lower four coefficients; the upper four follow
/// from the remainder at the end.
struct Piece {
  double h;

  /// Coefficients 4 to 7, for the given ends.
  Eigen::Vector4d upper(double p0, const Free& f0, double p1, const Free& f1) const {
    Eigen::Vector4d rest;
    rest << p1 - (p0 + h * (f0[0] + h * (f0[1] / 2 + h * f0[2] / 6))),
        f1[0] - (f0[0] + h * (f0[1] + h * f0[2] / 2)), f1[1] - (f0[1] + h * f0[2]), f1[2] - f0[2];
    // Scaled to duration 1: rest_k h^k; then divided back, c_k = b_k / h^k.
    Eigen::Vector4d b;
    const double r0 = rest[0], r1 = rest[1] * h, r2 = rest[2] * h * h, r3 = rest[3] * h * h * h;
    b << 35 * r0 - 15 * r1 + 2.5 * r2 - r3 / 6, -84 * r0 + 39 * r1 - 7 * r2 + r3 / 2,
        70 * r0 - 34 * r1 + 6.5 * r2 - r3 / 2, -20 * r0 + 10 * r1 - 2 * r2 + r3 / 6;
    double power = h * h * h * h;
    for (int k = 0; k < 4; ++k, power *= h) b[k] /= power;
    return b;
  }

  /// Derivatives 4 to 6 of the piece at its end (or at its beginning).
  Free outer(double p0, const Free& f0, double p1, const Free& f1, bool at_end) const {
    const Eigen::Vector4d c = upper(p0, f0, p1, f1);
    const double x = at_end ? h : 0.0;
    return {24 * c[0] + x * (120 * c[1] + x * (360 * c[2] + x * 840 * c[3])),
            120 * c[1] + x * (720 * c[2] + x * 2520 * c[3]), 720 * c[2] + x * 5040 * c[3]};
  }

  /// Derivatives of outer() by the free values at the beginning, or at the end.
  Block slope(bool by_end, bool at_end) const {
    Block block;
    for (int k = 0; k < 3; ++k) {
      const Free unit = Free::Unit(k), zero = Free::Zero();
      block.col(k) = by_end ? outer(0, zero, 0, unit, at_end) : outer(0, unit, 0, zero, at_end);
    }
    return block;
  }
};

/// Solves the block tridiagonal system for the free values: row i requires that derivatives 4 to 6
/// agree at knot i. Elimination from the first knot to the last (Thomas' algorithm).
/// @param p  values of one curve at the knots
std::vector<Free> solve(const std::vector<double>& times, const std::vector<double>& p,
                        SplineEnds ends) {
  const std::size_t n = times.size();
  const Free zero = Free::Zero();
  std::vector<Block> upper(n);
  std::vector<Free> right(n);
  for (std::size_t i = 0; i < n; ++i) {
    Block below = Block::Zero(), middle = Block::Zero(), above = Block::Zero();
    Free rhs = zero;
    if ((i == 0 || i + 1 == n) && ends == SplineEnds::kRest) {
      middle = Block::Identity();
    } else {
      if (i > 0) {
        const Piece before{times[i] - times[i - 1]};
        below = before.slope(false, true);
        middle += before.slope(true, true);
        rhs -= before.outer(p[i - 1], zero, p[i], zero, true);
      }
      if (i + 1 < n) {
        const Piece after{times[i + 1] - times[i]};
        middle -= after.slope(false, false);
        above -= after.slope(true, false);
        rhs += after.outer(p[i], zero, p[i + 1], zero, false);
      }
    }
    if (i > 0) {
      middle -= below * upper[i - 1];
      rhs -= below * right[i - 1];
    }
    const Eigen::PartialPivLU<Block> factors(middle);
    upper[i] = factors.solve(above);
    right[i] = factors.solve(rhs);
  }
  for (std::size_t i = n - 1; i-- > 0;) right[i] -= upper[i] * right[i + 1];
  return right;
}

}  // namespace

Spline::Spline(std::vector<double> times, const std::vector<double>& values, SplineEnds ends)
    : times_(std::move(times)) {
  coefficients_.resize(pieces() * kCurves * kCoefficients);
  for (int c = 0; c < kCurves; ++c) {
    std::vector<double> p(times_.size());
    for (std::size_t i = 0; i < p.size(); ++i) {
      p[i] = values[i * kCurves + static_cast<std::size_t>(c)];
    }
    const std::vector<Free> free = solve(times_, p, ends);
    for (std::size_t i = 0; i + 1 < p.size(); ++i) {
      const Piece piece{times_[i + 1] - times_[i]};
      const Eigen::Vector4d high = piece.upper(p[i], free[i], p[i + 1], free[i + 1]);
      double* const row =
          coefficients_.data() + (i * kCurves + static_cast<std::size_t>(c)) * kCoefficients;
      row[0] = p[i];
      row[1] = free[i][0];
      row[2] = free[i][1] / 2;
      row[3] = free[i][2] / 6;
      for (int k = 0; k < 4; ++k) row[4 + k] = high[k];
    }
  }
}

double Spline::peak_speed() const {
  constexpr int kSamples = 32;
  double peak = 0.0;
  for (std::size_t i = 0; i < pieces(); ++i) {
    for (int k = 0; k <= kSamples; ++k) {
      const double time =
          times_[i] - begin() + (times_[i + 1] - times_[i]) / kSamples * static_cast<double>(k);
      peak = max(peak, norm(derivative(at<2>(time).point, 1)));
    }
  }
  return peak;
}

Spline Spline::stretched(double factor) const {
  Spline out = *this;
  for (double& time : out.times_) time *= factor;
  for (std::size_t i = 0; i < out.coefficients_.size(); ++i) {
    for (std::size_t k = 0; k < i % kCoefficients; ++k) out.coefficients_[i] /= factor;
  }
  return out;
}

}  // namespace skybody::reference
