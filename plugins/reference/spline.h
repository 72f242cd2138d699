// Polynomial paths: seventh degree between knots, six continuous derivatives.
//
// Of all curves through the knots such a spline has the least integral of squared snap: at inner
// knots the derivatives 4 to 6 of neighbouring pieces agree, which is the stationarity of that
// integral in the free velocity, acceleration and jerk there. At the ends these three are zero
// (rest), or free, where derivatives 4 to 6 vanish.
//
// Sources: D. Mellinger and V. Kumar, Minimum snap trajectory generation and control for
// quadrotors, ICRA 2011, section IV. Conditions in terms of derivatives at the knots: C. Richter,
// A. Bry and N. Roy, Polynomial trajectory planning for aggressive quadrotor flight, ISRR 2013.
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/math/dual.h"
#include "core/base/simd/lanes.h"
#include "plugins/reference/path_jet.h"

namespace skybody::reference {

/// Condition at the first and the last knot: velocity, acceleration and jerk are 0 (kRest), or
/// derivatives 4 to 6 are 0 (kFree).
enum class SplineEnds { kRest, kFree };

/// Four curves over one sequence of times: x, y, z [m] (W) and yaw [rad].
class Spline {
 public:
  static constexpr int kCurves = 4, kCoefficients = 8;

  Spline() = default;
  /// The minimum-snap spline.
  /// @param times   of the knots [s]; two or more, increasing
  /// @param values  kCurves per knot
  Spline(std::vector<double> times, const std::vector<double>& values, SplineEnds ends);

  double begin() const { return times_.front(); }
  double end() const { return times_.back(); }
  std::size_t pieces() const { return times_.size() - 1; }

  /// A point and the yaw at path time `time`, counted from begin(). Before the first knot and after
  /// the last one the curve stays at its end.
  template <class Real, int N>
  struct Sample {
    PathPoint<Real, N> point;
    Jet<Real, N> yaw;
  };
  template <int N, class Real>
  SKYBODY_INLINE Sample<Real, N> at(const Real& time) const {
    const double length = end() - begin();
    const Real inside = clamp(time, Real(0.0), Real(length));
    ValueOf<Real> knot(0.0), coefficients[kCurves * kCoefficients] = {};
    const ValueOf<Real> plain = value_of(inside);
    for (int i = 0; i < kLanesOf<Real>; ++i) {
      const std::size_t piece = piece_at(lane(plain, i));
      set_lane(knot, i, times_[piece] - begin());
      const double* const row = coefficients_.data() + piece * kCurves * kCoefficients;
      for (int k = 0; k < kCurves * kCoefficients; ++k) set_lane(coefficients[k], i, row[k]);
    }
    const Real local = inside - Real(knot);
    const auto moves = logical_and(time >= 0.0, time <= length);
    Jet<Real, N> curves[kCurves];
    for (int c = 0; c < kCurves; ++c) {
      curves[c] = value_at<N>(coefficients + c * kCoefficients, local);
      for (int k = 1; k < N; ++k) {
        curves[c].c[k] = select(moves, curves[c].c[k], Real(0.0));
      }
    }
    return {{curves[0], curves[1], curves[2]}, curves[3]};
  }

  /// Greatest speed over the whole path [m/s], from 32 samples per piece.
  double peak_speed() const;
  /// The same path with all times multiplied by `factor`.
  Spline stretched(double factor) const;

 private:
  template <class R>
  static SKYBODY_INLINE R value_of(const R& x) {
    return x;
  }
  template <class R>
  static SKYBODY_INLINE R value_of(const Dual<R>& x) {
    return x.value;
  }

  /// The Taylor polynomial of sum of c_k x^k about `x`, by Horner's rule on jets.
  template <int N, class Real>
  static SKYBODY_INLINE Jet<Real, N> value_at(const ValueOf<Real>* c, const Real& x) {
    const auto variable = Jet<Real, N>::variable(x, Real(1.0));
    Jet<Real, N> sum(0.0);
    sum.c[0] = Real(c[kCoefficients - 1]);
    for (int k = kCoefficients - 2; k >= 0; --k) {
      sum = sum * variable;
      sum.c[0] = sum.c[0] + Real(c[k]);
    }
    return sum;
  }

  /// The piece at a time since begin(); for NaN the first one.
  std::size_t piece_at(double time) const {
    std::size_t low = 0, high = pieces();
    while (high - low > 1) {
      const std::size_t middle = low + (high - low) / 2;
      (times_[middle] - begin() <= time ? low : high) = middle;
    }
    return low;
  }

  std::vector<double> times_;
  std::vector<double> coefficients_;  ///< [piece][curve][power], about each piece's first knot
};

}  // namespace skybody::reference
