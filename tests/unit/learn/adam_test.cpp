#include "learn/network/adam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

double step(Adam& adam, const std::vector<float>& gradient, std::vector<float>& parameters) {
  std::copy(gradient.begin(), gradient.end(), adam.gradient().begin());
  return adam.step(parameters, 0.01);
}

/// Parameters after some steps, and the moments after them.
std::vector<float> after_steps(std::size_t count, Isa isa, int steps, double max_grad_norm = 0.0) {
  Adam adam(count, max_grad_norm, isa);
  std::vector<float> values = waves(count, 0.0);
  for (int t = 0; t < steps; ++t) step(adam, waves(count, t), values);
  const auto collect = [&](const std::string&, const auto* data, std::size_t size) {
    values.insert(values.end(), data, data + size);
  };
  Adam::visit(adam, "adam", collect);
  return values;
}

/// Sums in double; the kernels sum in another order.
double norm_of(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float v : values) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum);
}

TEST(Adam, TakesTheStepsOfItsEquations) {
  constexpr std::size_t kCount = 37;
  constexpr int kSteps = 20;
  constexpr double kMaxNorm = 2.0;
  std::vector<double> p, m(kCount), v(kCount);
  for (const float x : waves(kCount, 0.0)) p.push_back(static_cast<double>(x));
  for (int t = 1; t <= kSteps; ++t) {
    const std::vector<float> gradient = waves(kCount, t - 1);
    const double scale = std::min(1.0, kMaxNorm / (norm_of(gradient) + 1e-6));
    for (std::size_t i = 0; i < kCount; ++i) {
      const double g = scale * static_cast<double>(gradient[i]);
      m[i] = 0.9 * m[i] + 0.1 * g;
      v[i] = 0.999 * v[i] + 0.001 * g * g;
      const double unbiased_m = m[i] / (1.0 - std::pow(0.9, t));
      const double unbiased_v = v[i] / (1.0 - std::pow(0.999, t));
      p[i] -= 0.01 * unbiased_m / (std::sqrt(unbiased_v) + 1e-5);
    }
  }
  for (const Isa isa : isas()) {
    const std::vector<float> values = after_steps(kCount, isa, kSteps, kMaxNorm);
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
  EXPECT_EQ(after_steps(5003, sets[0], 9, 0.5), after_steps(5003, sets[1], 9, 0.5));
}

TEST(Adam, TreatsTheLastFewParametersAsTheOthers) {
  const std::vector<float> some = after_steps(21, best_isa(), 3);
  const std::vector<float> more = after_steps(32, best_isa(), 3);
  EXPECT_TRUE(std::equal(some.begin(), some.begin() + 21, more.begin()));
}

TEST(Adam, ReturnsTheNormOfTheWholeGradient) {
  for (const Isa isa : isas()) {
    for (const std::size_t count : {1u, 15u, 16u, 1000u, 1024u, 5003u}) {
      const std::vector<float> values = waves(count, 0.1);
      Adam adam(count, 0.5, isa);
      std::vector<float> parameters(count);
      // At most 64 roundings of 2^-24 per lane.
      EXPECT_NEAR(step(adam, values, parameters) / norm_of(values), 1.0, 1e-6) << count;
    }
  }
}

TEST(Adam, ChangesNothingByAGradientThatIsNotFinite) {
  Adam adam(20, 0.5, best_isa());
  std::vector<float> parameters = waves(20, 0.0);
  std::vector<float> gradient = waves(20, 1.0);
  gradient[18] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(std::isfinite(step(adam, gradient, parameters)));
  EXPECT_EQ(parameters, waves(20, 0.0));
  step(adam, waves(20, 1.0), parameters);
  std::vector<float> wanted = waves(20, 0.0);
  Adam fresh(20, 0.5, best_isa());
  step(fresh, waves(20, 1.0), wanted);
  EXPECT_EQ(parameters, wanted);
}

TEST(Adam, SumsGradientsInTheirOrder) {
  for (const Isa isa : isas()) {
    constexpr std::size_t kCount = 5003;
    Adam adam(kCount, 0.5, isa);
    const std::vector<float> a = waves(kCount, 0.0), b = waves(kCount, 1.0), c = waves(kCount, 2.0);
    const float* const gradients[] = {a.data(), b.data(), c.data()};
    adam.sum(gradients);
    for (std::size_t i = 0; i < kCount; ++i) EXPECT_EQ(adam.gradient()[i], (a[i] + b[i]) + c[i]);
  }
}

}  // namespace
}  // namespace skybody::learn
