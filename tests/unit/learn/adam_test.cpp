#include "learn/network/adam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

std::vector<float> waves(std::size_t count, double shift) {
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(static_cast<float>(std::sin(0.7 * static_cast<double>(i) + shift)));
  }
  return values;
}

/// Parameters after some steps, and the moments behind them.
std::vector<float> after_steps(std::size_t count, Isa isa, int steps) {
  Adam adam(count, isa);
  std::vector<float> parameters = waves(count, 0.0);
  for (int t = 0; t < steps; ++t) adam.step(waves(count, t), 0.01, 0.5, parameters);
  parameters.insert(parameters.end(), adam.first().begin(), adam.first().end());
  parameters.insert(parameters.end(), adam.second().begin(), adam.second().end());
  return parameters;
}

TEST(Adam, TakesTheStepsOfItsEquations) {
  constexpr std::size_t kCount = 37;
  constexpr int kSteps = 20;
  std::vector<double> p, m(kCount), v(kCount);
  for (const float x : waves(kCount, 0.0)) p.push_back(static_cast<double>(x));
  for (int t = 1; t <= kSteps; ++t) {
    const std::vector<float> gradient = waves(kCount, t - 1);
    for (std::size_t i = 0; i < kCount; ++i) {
      const double g = 0.5 * static_cast<double>(gradient[i]);
      m[i] = 0.9 * m[i] + 0.1 * g;
      v[i] = 0.999 * v[i] + 0.001 * g * g;
      const double unbiased_m = m[i] / (1.0 - std::pow(0.9, t));
      const double unbiased_v = v[i] / (1.0 - std::pow(0.999, t));
      p[i] -= 0.01 * unbiased_m / (std::sqrt(unbiased_v) + 1e-5);
    }
  }
  for (const Isa isa : isas()) {
    const std::vector<float> values = after_steps(kCount, isa, kSteps);
    for (std::size_t i = 0; i < kCount; ++i) {
      // Twenty roundings of parameters below 1, and of steps of 0.01.
      EXPECT_NEAR(static_cast<double>(values[i]), p[i], 2e-6) << name(isa);
      EXPECT_NEAR(static_cast<double>(values[kCount + i]), m[i], 1e-7) << name(isa);
      EXPECT_NEAR(static_cast<double>(values[2 * kCount + i]), v[i], 1e-8) << name(isa);
    }
  }
}

TEST(Adam, GivesTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  EXPECT_EQ(after_steps(37, sets[0], 9), after_steps(37, sets[1], 9));
  const std::vector<float> gradient = waves(5000, 0.3);
  EXPECT_EQ(gradient_norm(gradient, sets[0]), gradient_norm(gradient, sets[1]));
}

TEST(Adam, TreatsTheLastFewParametersAsTheOthers) {
  const std::vector<float> some = after_steps(21, best_isa(), 3);
  const std::vector<float> more = after_steps(32, best_isa(), 3);
  EXPECT_TRUE(std::equal(some.begin(), some.begin() + 21, more.begin()));
}

TEST(Adam, GoesOnFromARestoredState) {
  const Isa isa = best_isa();
  Adam adam(20, isa), restored(20, isa);
  std::vector<float> parameters = waves(20, 0.0);
  for (int t = 0; t < 3; ++t) adam.step(waves(20, t), 0.01, 1.0, parameters);
  restored.restore(adam.steps(), adam.first(), adam.second());
  std::vector<float> again = parameters;
  adam.step(waves(20, 9.0), 0.01, 1.0, parameters);
  restored.step(waves(20, 9.0), 0.01, 1.0, again);
  EXPECT_EQ(parameters, again);
}

TEST(Adam, RefusesTheStateOfOtherParameters) {
  Adam adam(20, best_isa());
  EXPECT_THROW(adam.restore(1, waves(19, 0.0), waves(20, 0.0)), Error);
  EXPECT_THROW(adam.restore(-1, waves(20, 0.0), waves(20, 0.0)), Error);
}

TEST(GradientNorm, IsTheEuclideanNorm) {
  for (const Isa isa : isas()) {
    for (const std::size_t count : {1u, 15u, 16u, 1000u, 1024u, 5003u}) {
      const std::vector<float> values = waves(count, 0.1);
      double sum = 0.0;
      for (const float v : values) sum += static_cast<double>(v) * static_cast<double>(v);
      // 64 roundings of 2^-24 a lane at the most.
      EXPECT_NEAR(gradient_norm(values, isa) / std::sqrt(sum), 1.0, 1e-6) << count;
    }
  }
}

TEST(GradientNorm, ScalesDownOnlyWhatIsLonger) {
  EXPECT_EQ(clip_scale(0.25, 0.5), 1.0);
  EXPECT_NEAR(clip_scale(2.0, 0.5), 0.25, 1e-6);
  EXPECT_EQ(clip_scale(0.0, 0.0), 0.0);
}

TEST(AddTo, AddsEveryValue) {
  for (const Isa isa : isas()) {
    std::vector<float> sum = waves(19, 0.0);
    const std::vector<float> before = sum, addend = waves(19, 1.0);
    add_to(addend, sum, isa);
    for (std::size_t i = 0; i < 19; ++i) EXPECT_EQ(sum[i], before[i] + addend[i]);
  }
}

}  // namespace
}  // namespace skybody::learn
