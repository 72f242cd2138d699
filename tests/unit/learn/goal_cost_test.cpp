// The cost of `gradient` against a second implementation of its equation in plain doubles, and its
// derivatives against differences of that implementation.
#include "learn/gradient/goal_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/physics/world/lane_values.h"

namespace skybody::learn {
namespace {

constexpr int kMotion = 13;
using Values = std::vector<double>;

/// R(q) x for unnormalised q, which differences produce: the matrix that is quadratic in q.
void turn(const double* q, const double* x, double* out) {
  const double w = q[0], a = q[1], b = q[2], c = q[3];
  const double m[3][3] = {{1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)},
                          {2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)},
                          {2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)}};
  for (int i = 0; i < 3; ++i) out[i] = m[i][0] * x[0] + m[i][1] * x[1] + m[i][2] * x[2];
}

/// @param target  the point's target; goals of a body's frame follow from it and the rotation
double cost_of(const Values& m, const Values& target, double yaw, const Values& velocity,
               const Values& point, double rate, double speed) {
  const double* w = &m[10];
  const double turning[3] = {w[1] * point[2] - w[2] * point[1], w[2] * point[0] - w[0] * point[2],
                             w[0] * point[1] - w[1] * point[0]};
  double arm[3], swing[3];
  turn(&m[3], point.data(), arm);
  turn(&m[3], turning, swing);
  double e[3], d = 0.0, off = 0.01, rates = 0.0;
  for (int k = 0; k < 3; ++k) {
    e[k] = target[static_cast<std::size_t>(k)] - m[static_cast<std::size_t>(k)] - arm[k];
    d += e[k] * e[k];
    rates += w[k] * w[k];
  }
  d = std::sqrt(d);
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double wanted = velocity[i] + e[k] / d * std::min(rate * d, speed);
    off += std::pow(m[7 + i] + swing[k] - wanted, 2);
  }
  const double heading =
      std::atan2(2.0 * (m[4] * m[5] + m[3] * m[6]), 1.0 - 2.0 * (m[5] * m[5] + m[6] * m[6]));
  const double turned = std::remainder(heading - yaw, 2.0 * std::acos(-1.0));
  return std::sqrt(off) + 0.3 * std::min(d, 1.0) + 0.5 * turned * turned + 0.02 * rates;
}

void expect_cost_and_derivatives(const Values& point, double reach) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Hyperparameters hyper;
  hyper.approach_rate = 2.0;
  hyper.approach_speed = 3.0;
  const GoalCost cost(hyper, {point[0], point[1], point[2]});
  AlignedArray<double> motion(kMotion * kGroupLanes), adjoints(kMotion * kGroupLanes);
  AlignedArray<double> goal(GoalCost::kGoalRows * kGroupLanes), sum(kGroupLanes);
  AlignedArray<double> distance(kGroupLanes);
  std::vector<Values> motions, targets, velocities;
  Values yaws;
  for (std::size_t l = 0; l < kGroupLanes; ++l) {
    Values m(kMotion), target(3), velocity(3);
    for (double& x : m) x = normal(random);
    const double size = std::sqrt(m[3] * m[3] + m[4] * m[4] + m[5] * m[5] + m[6] * m[6]);
    for (std::size_t k = 3; k < 7; ++k) m[k] /= size;
    double arm[3];
    turn(&m[3], point.data(), arm);
    yaws.push_back(normal(random));
    for (std::size_t k = 0; k < 3; ++k) {
      target[k] = m[k] + arm[k] + reach * normal(random);
      velocity[k] = normal(random);
      goal[k * kGroupLanes + l] = target[k] - arm[k];
      goal[(4 + k) * kGroupLanes + l] = velocity[k];
    }
    goal[3 * kGroupLanes + l] = yaws.back();
    for (std::size_t k = 0; k < kMotion; ++k) motion[k * kGroupLanes + l] = m[k];
    motions.push_back(m);
    targets.push_back(target);
    velocities.push_back(velocity);
  }
  constexpr double kWeight = 0.5;
  const std::uint32_t served = 0x7fffffffu;  // the last lane is inactive
  cost.add(served, kWeight, motion.data(), goal.data(), adjoints.data(), sum.data(),
           distance.data(), best_isa());
  for (std::size_t l = 0; l + 1 < kGroupLanes; ++l) {
    const auto at = [&](const Values& m) {
      return cost_of(m, targets[l], yaws[l], velocities[l], point, 2.0, 3.0);
    };
    // The engine adds 1e-6 m to the distance, so that it has a derivative at 0.
    EXPECT_NEAR(sum[l], kWeight * at(motions[l]), 1e-5);
    for (std::size_t k = 0; k < kMotion; ++k) {
      constexpr double kStep = 1e-6;
      Values above = motions[l], below = motions[l];
      above[k] += kStep;
      below[k] -= kStep;
      const double difference = kWeight * (at(above) - at(below)) / (2.0 * kStep);
      // That error, and the rounding of differences of numbers of about 10 over 1e-6.
      EXPECT_NEAR(adjoints[k * kGroupLanes + l], difference, 2e-5 * (1.0 + std::abs(difference)))
          << "value " << k << ", lane " << l;
    }
  }
  for (std::size_t k = 0; k < kMotion; ++k) EXPECT_EQ(adjoints[k * kGroupLanes + 31], 0.0);
}

TEST(GoalCost, HasItsDerivativesFarFromAGoalThatMoves) {
  expect_cost_and_derivatives({0.0, 0.0, 0.0}, 5.0);
}
TEST(GoalCost, HasItsDerivativesCloseToAGoalThatMoves) {
  expect_cost_and_derivatives({0.0, 0.0, 0.0}, 0.2);
}
TEST(GoalCost, BringsAPointOfABodyToItsGoal) {
  expect_cost_and_derivatives({0.1, -0.2, -0.4}, 0.3);
}

}  // namespace
}  // namespace skybody::learn
