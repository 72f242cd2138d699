#include "learn/network/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

std::vector<float> normals(std::size_t count, const NoiseCounter& counter, Isa isa = best_isa()) {
  std::vector<float> values(count);
  draw_normals(counter, values, isa);
  return values;
}

TEST(Noise, HasTheMomentsAndTheDistributionOfAStandardNormal) {
  constexpr std::size_t kCount = 1 << 20;
  std::vector<float> values = normals(kCount, {{1, 2}, 3, 4, 5});
  double sums[5] = {};
  for (const float v : values) {
    for (int k = 1; k <= 4; ++k) sums[k] += std::pow(static_cast<double>(v), k);
  }
  // Five standard errors: sqrt(1, 2, 15, 96) / sqrt(count).
  const double error = 5.0 / std::sqrt(static_cast<double>(kCount));
  EXPECT_NEAR(sums[1] / kCount, 0.0, error);
  EXPECT_NEAR(sums[2] / kCount, 1.0, error * std::sqrt(2.0));
  EXPECT_NEAR(sums[3] / kCount, 0.0, error * std::sqrt(15.0));
  EXPECT_NEAR(sums[4] / kCount, 3.0, error * std::sqrt(96.0));
  // Kolmogorov-Smirnov distance, at a level of 1e-6.
  std::sort(values.begin(), values.end());
  double distance = 0.0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double below = 0.5 * std::erfc(-static_cast<double>(values[i]) / std::sqrt(2.0));
    distance = std::max(distance, std::abs(below - (static_cast<double>(i) + 0.5) / kCount));
  }
  EXPECT_LT(distance, std::sqrt(std::log(2e6) / 2.0 / kCount));
}

TEST(Noise, IsNotCorrelatedBetweenNeighboursSinesAndCosinesOrSteps) {
  constexpr std::size_t kCount = 1 << 18;
  const std::vector<float> a = normals(kCount, {{1, 2}, 3, 4, 5});
  const std::vector<float> b = normals(kCount, {{1, 2}, 3, 4, 6});
  const auto correlation = [&](const std::vector<float>& x, std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < kCount; ++i) {
      sum += static_cast<double>(a[i]) * static_cast<double>(x[i + lag]);
    }
    return sum / kCount;
  };
  const double error = 5.0 / std::sqrt(static_cast<double>(kCount));
  for (const std::size_t lag : {1u, 2u, 16u, 32u}) EXPECT_NEAR(correlation(a, lag), 0.0, error);
  EXPECT_NEAR(correlation(b, 0), 0.0, error);
}

TEST(Noise, DoesNotDependOnHowManyNumbersAreAskedFor) {
  for (const Isa isa : isas()) {
    const std::vector<float> many = normals(300, {{1, 2}, 3, 4, 5}, isa);
    for (const std::size_t count : {1u, 15u, 16u, 33u, 128u, 129u, 299u}) {
      const std::vector<float> some = normals(count, {{1, 2}, 3, 4, 5}, isa);
      EXPECT_TRUE(std::equal(some.begin(), some.end(), many.begin())) << count;
    }
  }
}

TEST(Noise, IsOfEveryPartOfItsCounter) {
  const std::vector<float> first = normals(16, {{1, 2}, 3, 4, 5});
  const NoiseCounter others[] = {{{2, 2}, 3, 4, 5},
                                 {{1, 3}, 3, 4, 5},
                                 {{1, 2}, 4, 4, 5},
                                 {{1, 2}, 3, 5, 5},
                                 {{1, 2}, 3, 4, 6}};
  for (const NoiseCounter& other : others) EXPECT_NE(first, normals(16, other));
}

TEST(Noise, HasTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  EXPECT_EQ(normals(1000, {{1, 2}, 3, 4, 5}, sets[0]), normals(1000, {{1, 2}, 3, 4, 5}, sets[1]));
}

}  // namespace
}  // namespace skybody::learn
