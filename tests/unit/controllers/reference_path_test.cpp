// Paths of references: closed forms, derivatives against finite differences, smooth beginnings and
// least-snap splines.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "plugins/reference/path.h"

namespace skybody::reference {
namespace {

using V = Vec3<double>;

PathNumbers<double> numbers() {
  PathNumbers<double> n{};
  n.figure = {{0.3, -0.2, 1.5}, {1.7, 1.4, 0.35}, {2, 1, 2}, {1.6, 0.2, -0.4}, 0.5};
  n.rate = 0.9;
  n.step_time = 1.0;
  n.time_scale = 1.3;
  n.heading = 0.4;
  n.along = 1.0;
  n.offset = {0.5, -1.0, 0.7};
  return n;
}

/// Waypoints with different times, and separate yaw values.
Spline spline(SplineEnds ends = SplineEnds::kRest) {
  const std::vector<double> values = {0, 0, 1, 0, 1, 0.5, 1.2, 0.3, 2, -1, 1, 1, 0, 2, 1.5, -1};
  return Spline({0, 1.1, 1.9, 3.4}, values, ends);
}

std::vector<Path> paths() {
  std::vector<Path> all;
  for (const Kind kind : {Kind::kLissajous, Kind::kCircle, Kind::kHelix, Kind::kFigureEight}) {
    all.push_back({kind, Facing::kTangent, 2.0, 1.5, {}});
  }
  all.push_back({Kind::kWaypoints, Facing::kFixed, 0.0, 1.0, spline()});
  all.push_back({Kind::kCsv, Facing::kTable, 1.0, 0.0, spline()});
  return all;
}

double component(const V& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

TEST(ReferencePath, EachDerivativeIsTheSlopeOfTheOneBefore) {
  const PathNumbers<double> n = numbers();
  const double h = 1e-5;
  for (const Path& path : paths()) {
    for (double t = 0.05; t < 6.0; t += 0.137) {
      const auto before = path.at<kOrders>(n, t - h), after = path.at<kOrders>(n, t + h);
      const auto now = path.at<kOrders>(n, t);
      for (int k = 1; k < kOrders; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          const double slope = (component(derivative(after.point, k - 1), axis) -
                                component(derivative(before.point, k - 1), axis)) /
                               (2 * h);
          const double exact = component(derivative(now.point, k), axis);
          // Central differences: rounding 1e-16 / h, truncation h^2 times a third derivative.
          EXPECT_NEAR(slope, exact, 1e-6 * (1.0 + std::abs(exact)) + 2e-6 * k)
              << "kind " << static_cast<int>(path.kind) << ", derivative " << k << " at " << t;
        }
      }
      const double turn = std::remainder(after.yaw.c[0] - before.yaw.c[0], 2 * kPi) / (2 * h);
      EXPECT_NEAR(turn, now.yaw.c[1], 1e-5 * (1.0 + std::abs(turn)));
    }
  }
}

TEST(ReferencePath, ACircleHasItsRadiusSpeedAndInwardAcceleration) {
  PathNumbers<double> n = numbers();
  n.figure = {{1, 2, 3}, {2, 2, 0}, {1, 1, 1}, {kHalfPi, 0, 0}, 0};
  n.time_scale = 1.0;
  const Path path{Kind::kCircle, Facing::kTangent, 0.0, 0.0, {}};
  for (double t = 0.0; t < 8.0; t += 0.61) {
    const auto at = path.at<kOrders>(n, t);
    const V arm = derivative(at.point, 0) - V{1, 2, 3};
    EXPECT_NEAR(arm.x, 2 * std::cos(0.9 * t), 1e-14);
    EXPECT_NEAR(arm.y, 2 * std::sin(0.9 * t), 1e-14);
    EXPECT_NEAR(norm(derivative(at.point, 1)), 1.8, 1e-14);
    EXPECT_NEAR(norm(derivative(at.point, 2) + arm * 0.81), 0.0, 1e-14);
    EXPECT_NEAR(norm(derivative(at.point, 4) - arm * (0.81 * 0.81)), 0.0, 1e-14);
    EXPECT_NEAR(at.yaw.c[1], 0.9, 1e-14);  // the heading turns with the circle
  }
}

TEST(ReferencePath, BeginsAtRestAtTheVehicleAndIsSmoothWhereApproachAndRampEnd) {
  const PathNumbers<double> n = numbers();
  const Path path{Kind::kLissajous, Facing::kTangent, 2.0, 1.5, {}};
  const auto begin = path.at<kOrders>(n, 0.0), on = path.at<kOrders>(n, 1.5);
  for (int k = 1; k < kOrders; ++k) {
    EXPECT_EQ(norm(derivative(begin.point, k)), 0.0) << k;
    EXPECT_NEAR(norm(derivative(on.point, k)), 0.0, 1e-12) << k;
  }
  EXPECT_NEAR(norm(derivative(begin.point, 0) - derivative(on.point, 0) - n.offset), 0.0, 1e-14);
  for (const double join : {1.5, 3.5}) {
    const auto before = path.at<kOrders>(n, join - 1e-7), after = path.at<kOrders>(n, join + 1e-7);
    for (int k = 0; k < kOrders; ++k) {  // snap has slopes of up to 126 5! o / 1.5^5, 2600 m/s^5
      EXPECT_NEAR(norm(derivative(after.point, k) - derivative(before.point, k)), 0.0, 3e-4)
          << join << " " << k;
    }
  }
}

TEST(ReferencePath, PeakSpeedOfAFigureIsWithinASixthOfAPercent) {
  const Harmonic<double> figure = numbers().figure;
  double peak = 0.0;
  for (int k = 0; k < 1000000; ++k) {
    peak = std::max(peak, norm(derivative(figure.at<2>(2e-6 * kPi * k, 1.0), 1)));
  }
  EXPECT_LE(figure.steepest(), peak * (1 + 1e-12));
  EXPECT_GE(figure.steepest(), peak * (1 - 1.5e-3));
}

TEST(ReferencePath, AStepJumpsOnceAndHoldStays) {
  PathNumbers<double> n = numbers();
  n.time_scale = 1.0;
  const Path step{Kind::kStep, Facing::kFixed, 0.0, 0.0, {}};
  const Path hold{Kind::kHold, Facing::kFixed, 0.0, 0.0, {}};
  EXPECT_EQ(derivative(step.at<2>(n, 0.999).point, 0).x, 0.3);
  EXPECT_EQ(derivative(step.at<2>(n, 1.0).point, 0).x, 0.3 + 1.7);
  EXPECT_EQ(derivative(step.at<2>(n, 5.0).point, 1).x, 0.0);
  EXPECT_EQ(derivative(hold.at<2>(n, 5.0).point, 0).z, 1.5);
  EXPECT_EQ(hold.at<2>(n, 5.0).yaw.c[0], 0.4);
}

TEST(Spline, PassesItsKnotsAndRestsAtItsEnds) {
  const Spline s = spline();
  EXPECT_NEAR(s.at<1>(0.0).point.z.c[0], 1.0, 1e-14);
  EXPECT_NEAR(s.at<1>(1.1).point.y.c[0], 0.5, 1e-12);
  EXPECT_NEAR(s.at<1>(1.9).point.x.c[0], 2.0, 1e-12);
  EXPECT_NEAR(s.at<1>(3.4).yaw.c[0], -1.0, 1e-12);
  for (const double end : {0.0, 3.4}) {
    for (int k = 1; k < 4; ++k) {
      EXPECT_NEAR(norm(derivative(s.at<kOrders>(end).point, k)), 0.0, 1e-9) << end << " " << k;
    }
  }
  EXPECT_EQ(s.at<2>(9.0).point.x.c[0], s.at<2>(3.4).point.x.c[0]);  // stays at its end
  EXPECT_EQ(s.at<2>(9.0).point.x.c[1], 0.0);
}

TEST(Spline, BetweenTwoPointsAtRestIsThePolynomialOfLeastSnap) {
  const Spline s({0, 2}, {0, 0, 0, 0, 3, 0, 0, 0}, SplineEnds::kRest);
  for (double t = 0.0; t <= 2.0; t += 0.1) {
    const double x = t / 2;
    const double rise = x * x * x * x * (35 + x * (-84 + x * (70 - 20 * x)));
    EXPECT_NEAR(s.at<1>(t).point.x.c[0], 3 * rise, 1e-13);
  }
}

TEST(Spline, SixDerivativesAreContinuousAtInnerKnots) {
  for (const SplineEnds ends : {SplineEnds::kRest, SplineEnds::kFree}) {
    const Spline s = spline(ends);
    for (const double knot : {1.1, 1.9}) {
      const auto before = s.at<7>(knot - 1e-9), after = s.at<7>(knot + 1e-9);
      for (int k = 0; k < 7; ++k) {
        const double scale = 1.0 + std::abs(after.point.x.derivative(k));
        EXPECT_NEAR(before.point.x.derivative(k), after.point.x.derivative(k), 1e-5 * scale) << k;
      }
    }
  }
}

TEST(Spline, FreeEndsHaveNoSnapAndACubicIsReproduced) {
  // The snap of a cubic is zero, so the cubic is the least-snap curve through its own points.
  const auto cubic = [](double t) { return 1 + t * (0.5 + t * (-0.7 + 0.2 * t)); };
  std::vector<double> times, values;
  for (const double t : {0.0, 0.4, 1.1, 1.5, 2.3, 3.0}) {
    times.push_back(t);
    values.insert(values.end(), {cubic(t), 0.0, 0.0, 0.0});
  }
  const Spline s(times, values, SplineEnds::kFree);
  for (double t = 0.0; t < 3.0; t += 0.07) {
    EXPECT_NEAR(s.at<1>(t).point.x.c[0], cubic(t), 1e-10);
    EXPECT_NEAR(s.at<kOrders>(t).point.x.derivative(4), 0.0, 1e-7);
  }
}

TEST(Spline, StretchedInTimeKeepsItsPlacesAndDividesItsSpeeds) {
  const Spline s = spline(), slow = s.stretched(2.5);
  for (double t = 0.05; t < 3.4; t += 0.21) {
    EXPECT_NEAR(slow.at<2>(2.5 * t).point.x.c[0], s.at<2>(t).point.x.c[0], 1e-12);
    EXPECT_NEAR(slow.at<2>(2.5 * t).point.x.c[1], s.at<2>(t).point.x.c[1] / 2.5, 1e-12);
  }
  EXPECT_NEAR(slow.peak_speed(), s.peak_speed() / 2.5, 1e-12);
}

}  // namespace
}  // namespace skybody::reference
