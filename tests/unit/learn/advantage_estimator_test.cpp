// Generalized advantage estimates against their definition.
#include "learn/rollout/advantage_estimator.h"

#include <gtest/gtest.h>

namespace skybody::learn {
namespace {

/// Three steps of two rows: the first row goes on, the second ends in the middle.
AdvantageEstimator three_steps(float end_value) {
  AdvantageEstimator estimator(3, 2);
  estimator.begin();
  for (int step = 0; step < 3; ++step) {
    estimator.set(estimator.at(step, 0), 1.0f, true);
    estimator.set(estimator.at(step, 1), 1.0f, step != 1);
  }
  estimator.set_end_value(estimator.at(1, 1), end_value);
  for (int step = 0; step <= 3; ++step) {
    for (int row = 0; row < 2; ++row) {
      estimator.values()[estimator.at(step, row)] = 0.5f * static_cast<float>(step);
    }
  }
  return estimator;
}

TEST(AdvantageEstimator, SumsRewardsToTheValueAfterTheRolloutWithLambdaOne) {
  AdvantageEstimator estimator = three_steps(0.0f);
  estimator.estimate({0.5f, 1.0f, 2.0f}, [](int step, int row, float advantage, float target) {
    const float value = 0.5f * static_cast<float>(step);
    EXPECT_FLOAT_EQ(target, advantage + value);
    if (row != 0) return;
    // Rewards of 2 each, then the value of 1.5, each step discounted by a half.
    float wanted = 1.5f;
    for (int k = step; k < 3; ++k) wanted = 2.0f + 0.5f * wanted;
    EXPECT_FLOAT_EQ(target, wanted) << step;
  });
}

TEST(AdvantageEstimator, TakesNothingFromAfterAnEnd) {
  for (const float end_value : {0.0f, 4.0f}) {
    AdvantageEstimator estimator = three_steps(end_value);
    estimator.estimate({0.5f, 1.0f, 1.0f}, [&](int step, int row, float, float target) {
      if (row != 1) return;
      const float last = 1.0f + 0.5f * end_value;  // target of the step that ends the episode
      const float wanted[] = {1.0f + 0.5f * last, last, 1.0f + 0.5f * 1.5f};
      EXPECT_FLOAT_EQ(target, wanted[step]) << step;
    });
  }
}

TEST(AdvantageEstimator, IsTheErrorOfOneStepWithLambdaZero) {
  AdvantageEstimator estimator = three_steps(0.0f);
  estimator.estimate({0.5f, 0.0f, 1.0f}, [](int step, int row, float advantage, float) {
    const float value = 0.5f * static_cast<float>(step);
    if (row != 0) return;
    EXPECT_FLOAT_EQ(advantage, 1.0f + 0.5f * (value + 0.5f) - value);
  });
}

TEST(AdvantageEstimator, ForgetsEndValuesAtTheBeginningOfARollout) {
  AdvantageEstimator estimator = three_steps(4.0f);
  estimator.begin();
  for (const float value : estimator.end_values()) EXPECT_EQ(value, 0.0f);
}

}  // namespace
}  // namespace skybody::learn
