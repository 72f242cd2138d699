// Distributions: draws against the cumulative distributions in closed form.
#include "core/base/math/distribution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/math/random.h"

namespace skybody {
namespace {

constexpr int kDraws = 10000;

double share_below(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// Largest difference between the empirical distribution of 10,000 draws and `cumulative`.
double distance(const Distribution& d, const std::function<double(double)>& cumulative) {
  Random<double> random{RandomKey{2026, 91}, 0, 0, derive_stream("distribution_test")};
  std::vector<double> values;
  for (int k = 0; k < kDraws; ++k) values.push_back(d.at(random.uniform()));
  std::sort(values.begin(), values.end());
  double largest = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    const double exact = cumulative(values[static_cast<std::size_t>(k)]);
    largest = std::max({largest, exact - k / double{kDraws}, (k + 1) / double{kDraws} - exact});
  }
  return largest;
}

/// Kolmogorov-Smirnov limit, exceeded with probability 1e-3.
const double kFar = 1.95 / std::sqrt(double{kDraws});

TEST(Distribution, UniformDrawsAreUniform) {
  EXPECT_LT(distance(make_uniform(-2.0, 3.0), [](double x) { return (x + 2.0) / 5.0; }), kFar);
}

TEST(Distribution, LogarithmsOfLogUniformDrawsAreUniform) {
  const auto cumulative = [](double x) { return std::log(x / 0.01) / std::log(1000.0); };
  EXPECT_LT(distance(make_log_uniform(0.01, 10.0), cumulative), kFar);
}

TEST(Distribution, NormalDrawsAreCutOffAsIfTheyHadBeenDrawnAgain) {
  const double low = share_below(-0.5), high = share_below(3.0);
  const auto cumulative = [&](double x) {
    return (share_below((x - 1.0) / 2.0) - low) / (high - low);
  };
  EXPECT_LT(distance(make_normal(1.0, 2.0, 0.0, 7.0), cumulative), kFar);
}

TEST(Distribution, AChoiceComesAsOftenAsItsWeight) {
  const Distribution d = make_choice({3.0, -1.0, 8.0}, {0.2, 0.5, 0.3});
  Random<double> random{RandomKey{2026, 92}, 0, 0, derive_stream("distribution_test")};
  int counts[3] = {};
  for (int k = 0; k < kDraws; ++k) {
    const double value = d.at(random.uniform());
    ++counts[value == 3.0 ? 0 : value == -1.0 ? 1 : 2];
  }
  const double expected[3] = {0.2, 0.5, 0.3};
  for (int k = 0; k < 3; ++k) {  // four standard deviations
    const double deviation = std::sqrt(kDraws * expected[k] * (1.0 - expected[k]));
    EXPECT_NEAR(counts[k], kDraws * expected[k], 4.0 * deviation);
  }
}

TEST(Distribution, StaysWithinItsEnds) {
  for (const Distribution& d :
       {make_uniform(0.1, 0.3), make_log_uniform(0.1, 0.3), make_normal(5.0, 3.0, 0.1, 0.3)}) {
    for (const double u : {0.0, 1e-17, 0.5, 1.0 - 0x1p-53}) {
      EXPECT_GE(d.at(u), 0.1);
      EXPECT_LE(d.at(u), 0.3);
    }
  }
  EXPECT_EQ(make_constant(7.0).at(0.9), 7.0);
}

TEST(Distribution, PacksHaveTheBitsOfDoubles) {
  Random<Pack<4>> packs{RandomKey{2026, 93}, 0, 0, derive_stream("distribution_test")};
  for (const Distribution& d : {make_uniform(-1.0, 2.0), make_log_uniform(1e-3, 5.0),
                                make_normal(0.0, 1.0, -3.0, 4.0), make_choice({1.0, 2.0, 4.0})}) {
    for (int k = 0; k < 200; ++k) {
      Pack<4> u = packs.uniform();
      for (int i = 0; i < 4; ++i) {
        set_lane(u, i, std::fmod(lane(u, i) * (3.0 + i) + 0.1 * i, 1.0));
      }
      const Pack<4> value = d.at(u);
      for (int i = 0; i < 4; ++i) EXPECT_EQ(lane(value, i), d.at(lane(u, i)));
    }
  }
}

TEST(NormalQuantile, IsTheInverseOfTheErrorFunction) {
  for (double x = -8.0; x < 5.0; x += 0.01) {  // beyond this, 1 - p has too few digits
    // Error of x by the rounding of p, plus a few roundings of the quantile itself.
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi);
    const double p = share_below(x), rounding = (x < 0.0 ? p : 1.0) * 1e-15 / density;
    EXPECT_NEAR(normal_quantile(p), x, rounding + 1e-14 * (1.0 + std::fabs(x))) << x;
    EXPECT_NEAR(normal_cdf(x), share_below(x), 1e-15) << x;
  }
  EXPECT_EQ(normal_quantile(0.5), 0.0);
  EXPECT_EQ(normal_cdf(-1e9), 0.0);
  EXPECT_EQ(normal_cdf(1e9), 1.0);
}

TEST(Distribution, SaysWhatItCannotBe) {
  const auto refusal = [](const std::function<void()>& make) {
    try {
      make();
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal([] { make_uniform(2.0, 1.0); }), HasSubstr("runs backwards"));
  EXPECT_THAT(refusal([] { make_uniform(0.0, kNan); }), HasSubstr("runs backwards"));
  EXPECT_THAT(refusal([] { make_log_uniform(0.0, 1.0); }), HasSubstr("above 0"));
  EXPECT_THAT(refusal([] { make_normal(0.0, 0.0, 0.0, 1.0); }), HasSubstr("deviation is 0"));
  EXPECT_THAT(refusal([] { make_normal(0.0, 1.0, 9.0, 10.0); }), HasSubstr("a millionth"));
  EXPECT_THAT(refusal([] { make_choice({}); }), HasSubstr("at least one value"));
  EXPECT_THAT(refusal([] { make_choice({1.0, 2.0}, {1.0}); }), HasSubstr("2 values and 1 weights"));
  EXPECT_THAT(refusal([] { make_choice({1.0, 2.0}, {0.5, 0.4}); }), HasSubstr("add up to 0.9"));
  EXPECT_THAT(refusal([] { make_choice({1.0, 2.0}, {1.5, -0.5}); }), HasSubstr("not above 0"));
}

}  // namespace
}  // namespace skybody
