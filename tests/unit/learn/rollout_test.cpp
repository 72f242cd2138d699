// A rollout for algorithms of one's own.
#include "learn/rollout/rollout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/unit/learn/small_team.h"

namespace skybody::learn {
namespace {

using test::small_team;

RolloutOptions small_rollout(int threads = 1) {
  return {.compiled = small_team(), .envs = 5, .steps = 12, .seed = 3, .threads = threads};
}

/// Actions that differ between rows and steps, so that some episodes end early.
void choose(int step, const float* x, std::span<float> actions) {
  for (std::size_t k = 0; k < actions.size(); ++k) {
    actions[k] =
        static_cast<float>(0.4 * std::sin(static_cast<double>(k) + 0.1 * step)) + 0.01f * x[0];
  }
}

/// The value of an observation: its second input.
void value(const Rollout& rollout, const float* x, int rows, float* y) {
  for (int r = 0; r < rows; ++r) y[r] = x[r * rollout.stride() + 1];
}

TEST(Rollout, HasOneRowForEachTransition) {
  Rollout rollout(small_rollout());
  int steps = 0;
  rollout.collect([&](int step, const float* x, std::span<float> actions) {
    EXPECT_EQ(step, steps++);
    EXPECT_EQ(x, rollout.observations(step));
    EXPECT_EQ(actions.size(), 5u * 8u);
    choose(step, x, actions);
  });
  EXPECT_EQ(steps, 12);
  EXPECT_EQ(rollout.rows(), 60);
  EXPECT_EQ(rollout.total_steps(), 60);
  EXPECT_EQ(rollout.actions().size(), 60u * 8u);
  EXPECT_EQ(rollout.rewards().size(), 60u);
}

TEST(Rollout, AdvantagesAreThoseOfTheScaledRewards) {
  RolloutOptions options = small_rollout();
  options.gae_lambda = 0.0;
  options.discount = 0.9;
  Rollout rollout(options);
  for (int k = 0; k < 3; ++k) rollout.collect(choose);
  int calls = 0;
  rollout.find_advantages([&](const float* x, int rows, float* y) {
    ++calls;
    value(rollout, x, rows, y);
  });
  EXPECT_GE(calls, 1);
  std::vector<double> scales;
  for (int step = 0; step + 1 < 12; ++step) {
    for (int env = 0; env < 5; ++env) {
      const auto i = static_cast<std::size_t>(5 * step + env);
      const double now = rollout.observations(step)[env * rollout.stride() + 1];
      const double next = rollout.observations(step + 1)[env * rollout.stride() + 1];
      EXPECT_NEAR(rollout.targets()[i], static_cast<double>(rollout.advantages()[i]) + now, 1e-5);
      const double reward = rollout.advantages()[i] - 0.9 * next + now;
      scales.push_back(reward / static_cast<double>(rollout.rewards()[i]));
    }
  }
  // The factor of the rewards is one number, except at ends of episodes.
  std::sort(scales.begin(), scales.end());
  const double middle = scales[scales.size() / 2];
  EXPECT_GT(middle, 0.0);
  const auto equal = std::count_if(scales.begin(), scales.end(), [&](double scale) {
    return std::abs(scale - middle) < 1e-3 * middle;
  });
  EXPECT_GT(equal, 40);
}

TEST(Rollout, IsTheSameOnAnyNumberOfThreads) {
  std::vector<float> advantages[2];
  for (const int threads : {1, 3}) {
    Rollout rollout(small_rollout(threads));
    for (int k = 0; k < 3; ++k) rollout.collect(choose);
    rollout.find_advantages(
        [&](const float* x, int rows, float* y) { value(rollout, x, rows, y); });
    advantages[threads == 1].assign(rollout.advantages().begin(), rollout.advantages().end());
  }
  EXPECT_EQ(advantages[0], advantages[1]);
}

TEST(Rollout, FreezesItsStatistics) {
  RolloutOptions options = small_rollout();
  options.normalization_steps = 60;
  Rollout rollout(options);
  rollout.collect(choose);
  const std::vector<double> mean = rollout.normalizer().moments().mean;
  EXPECT_NE(mean[1], 0.0);
  rollout.collect(choose);
  EXPECT_EQ(rollout.normalizer().moments().mean, mean);
}

TEST(Rollout, RefusesOptionsOutOfRange) {
  RolloutOptions options = small_rollout();
  options.discount = 1.5;
  EXPECT_THROW(Rollout{options}, Error);
  options = small_rollout();
  options.steps = 0;
  EXPECT_THROW(Rollout{options}, Error);
}

}  // namespace
}  // namespace skybody::learn
