// The parts of PPO against plain formulas.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "learn/common/gaussian.h"
#include "learn/common/learner_threads.h"
#include "learn/common/normalizer.h"
#include "learn/common/running_moments.h"
#include "learn/ppo/policy_loss.h"

namespace skybody::learn {
namespace {

TEST(RunningMoments, OfAColumnThatHardlyChangesStayFinite) {
  // The sums of a rollout; differences are still taken from a mean of 0. For some of these
  // constants, rounding makes the variance negative by more than the added regularisation.
  for (int k = 0; k < 1000; ++k) {
    const double value = 1e5 + 0.37 * k;
    double sum = 0.0, squares = 0.0;
    for (int row = 0; row < 8192; ++row) {
      sum += value;
      squares += value * value;
    }
    RunningMoments moments(1);
    moments.add(8192, std::span(&sum, 1), std::span(&squares, 1));
    EXPECT_TRUE(std::isfinite(moments.scale(0))) << value;
  }
}

TEST(RunningMoments, AreThoseOfAllRows) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(3.0, 2.0);
  std::vector<double> all;
  RunningMoments moments(1);
  for (const int rows : {5, 1, 40}) {
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < rows; ++k) {
      all.push_back(normal(random));
      sum += all.back() - moments.mean[0];
      squares += (all.back() - moments.mean[0]) * (all.back() - moments.mean[0]);
    }
    moments.add(rows, std::span(&sum, 1), std::span(&squares, 1));
  }
  double mean = 0.0, variance = 0.0;
  for (const double x : all) mean += x / static_cast<double>(all.size());
  for (const double x : all) variance += (x - mean) * (x - mean) / static_cast<double>(all.size());
  EXPECT_NEAR(moments.mean[0], mean, 1e-13);
  EXPECT_NEAR(moments.variance[0], variance, 1e-13);
}

TEST(Normalizer, ClipsAndAddsUpWhatItSaw) {
  std::vector<float> rows = {1.0f, 20.0f, 0.0f, 3.0f, -50.0f, 0.0f};
  const std::vector<double> mean = {2.0, 0.0}, scale = {0.5, 1.0};
  double sum[2] = {}, squares[2] = {};
  const ColumnSums sums{sum, squares};
  Normalizer(10.0, best_isa()).apply(rows.data(), 2, 3, mean, scale, &sums);
  EXPECT_THAT(rows, testing::ElementsAre(-0.5f, 10.0f, 0.0f, 0.5f, -10.0f, 0.0f));
  EXPECT_THAT(sum, testing::ElementsAre(0.0, -30.0));
  EXPECT_THAT(squares, testing::ElementsAre(2.0, 2900.0));
}

/// All results for a loss of few rows, in double and by the formulas only.
struct LossCase {
  static constexpr int kRows = 9, kActions = 2, kStride = 16;
  std::vector<float> rows = std::vector<float>(kRows * kStride);
  std::vector<float> outputs = std::vector<float>(kRows * kActions), log_std = {-0.3f, 0.2f};
  PolicyLossTerms terms{0.2, 0.4, 1.3, 1.0 / kRows, false};

  explicit LossCase(bool is_bounded) {
    terms.is_bounded = is_bounded;
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (float& x : rows) x = normal(random);
    for (float& x : outputs) x = 0.5f * normal(random);
    // Log-probabilities near the current ones: ratios below, inside and above the range.
    for (int r = 0; r < kRows; ++r) {
      const double now = log_probability(r, outputs_as_double(), log_std_as_double());
      rows[static_cast<std::size_t>(r * kStride + 2)] =
          static_cast<float>(now + 0.1 * (r - 4) + 0.03);
    }
  }

  std::vector<double> outputs_as_double() const { return {outputs.begin(), outputs.end()}; }
  std::vector<double> log_std_as_double() const { return {log_std.begin(), log_std.end()}; }

  double log_probability(int r, const std::vector<double>& out,
                         const std::vector<double>& logs) const {
    double sum = 0.0;
    for (int k = 0; k < kActions; ++k) {
      const double raw = out[static_cast<std::size_t>(r * kActions + k)];
      const double mean = terms.is_bounded ? std::tanh(raw) : raw;
      const double z = (rows[static_cast<std::size_t>(r * kStride + k)] - mean) /
                       std::exp(logs[static_cast<std::size_t>(k)]);
      sum += -0.5 * z * z - logs[static_cast<std::size_t>(k)];
    }
    return sum;
  }
  double loss(const std::vector<double>& out, const std::vector<double>& logs) const {
    double sum = 0.0;
    for (int r = 0; r < kRows; ++r) {
      const float* row = rows.data() + r * kStride;
      const double ratio = std::exp(log_probability(r, out, logs) - static_cast<double>(row[2]));
      const double advantage = (static_cast<double>(row[3]) - 0.4) * 1.3;
      const double clipped = std::min(std::max(ratio, 0.8), 1.2);
      sum -= std::min(ratio * advantage, clipped * advantage) / kRows;
    }
    return sum;
  }
};

class PolicyLossOf : public testing::TestWithParam<bool> {};

TEST_P(PolicyLossOf, GradientIsThatOfFiniteDifferences) {
  LossCase c(GetParam());
  std::vector<float> means = c.outputs, gradient(means.size());
  if (GetParam()) apply_tanh(means.data(), means.size(), best_isa());
  Deviations deviations;
  deviations.update(c.log_std);
  std::vector<double> log_std_gradient(2);
  PolicyFigures figures;
  PolicyLoss(LossCase::kRows, best_isa())
      .apply({LossCase::kRows, c.rows.data(), c.rows.data() + 2, c.rows.data() + 3,
              LossCase::kStride, means.data()},
             deviations, c.terms, gradient.data(), log_std_gradient, figures);
  EXPECT_NEAR(figures.loss / LossCase::kRows, c.loss(c.outputs_as_double(), c.log_std_as_double()),
              1e-6);  // float log-probabilities
  EXPECT_GT(figures.clipped, 1.0);
  EXPECT_LT(figures.clipped, LossCase::kRows - 1.0);
  EXPECT_GT(figures.kl, 0.0);
  constexpr double kStep = 1e-6;
  std::vector<double> out = c.outputs_as_double(), logs = c.log_std_as_double();
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] += kStep;
    const double above = c.loss(out, logs);
    out[i] -= 2 * kStep;
    const double below = c.loss(out, logs);
    out[i] += kStep;
    EXPECT_NEAR(gradient[i], (above - below) / (2 * kStep), 2e-6) << i;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    logs[k] += kStep;
    const double above = c.loss(out, logs);
    logs[k] -= 2 * kStep;
    const double below = c.loss(out, logs);
    logs[k] += kStep;
    EXPECT_NEAR(log_std_gradient[k], (above - below) / (2 * kStep), 2e-6) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(PolicyLoss, PolicyLossOf, testing::Bool(),
                         [](const auto& c) { return c.param ? "BoundedMean" : "FreeMean"; });

TEST(LearnerThreads, RunsEachTaskOnceAndPassesOnWhatOneThrows) {
  LearnerThreads threads(3, 8);
  for (int round = 0; round < 50; ++round) {
    std::vector<int> runs(8);
    threads.run(8, [&](int task, int) { ++runs[static_cast<std::size_t>(task)]; });
    ASSERT_THAT(runs, testing::Each(1));
  }
  std::atomic<int> ended{0};
  const auto bad = [&](int task, int) {
    ++ended;
    if (task == 3) throw std::runtime_error("three");
  };
  EXPECT_THROW(threads.run(8, bad), std::runtime_error);
  EXPECT_EQ(ended.load(), 8);
  threads.run(2, [&](int, int) { ++ended; });  // it continues
  EXPECT_EQ(ended.load(), 10);
}

}  // namespace
}  // namespace skybody::learn
