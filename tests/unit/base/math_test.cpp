// Core math against long double libm: error bounds in ulp, and the special values.
#include "core/base/math/math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace skybody {
namespace {

/// |got - reference| in ulp of a double as large as the reference.
double ulps(double got, long double reference) {
  if (std::isnan(got) || std::isinf(got)) {
    const double rounded = static_cast<double>(reference);
    return got == rounded || (std::isnan(got) && std::isnan(rounded)) ? 0.0 : 1e300;
  }
  const int exponent = reference == 0.0L ? -1074 : std::max(std::ilogb(reference) - 52, -1074);
  return static_cast<double>(std::fabs(got - reference) / std::ldexp(1.0L, exponent));
}

/// Evenly spaced, uniformly random and logarithmically random inputs of both signs in [low, high].
std::vector<double> inputs(double low, double high) {
  std::vector<double> all;
  std::mt19937_64 bits(20260101);
  const auto uniform = [&bits] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  for (int i = 0; i <= 20000; ++i) all.push_back(low + (high - low) * (i / 20000.0));
  for (int i = 0; i < 60000; ++i) all.push_back(low + (high - low) * uniform());
  for (int i = 0; i < 60000; ++i) {
    const double x = std::ldexp(1.0 + uniform(), static_cast<int>(uniform() * 80) - 60);
    for (const double signed_x : {x, -x}) {
      if (signed_x >= low && signed_x <= high) all.push_back(signed_x);
    }
  }
  return all;
}

template <class Function, class Reference>
void expect_ulps(const char* name, double bound, double low, double high, Function function,
                 Reference reference) {
  double worst = 0.0, where = 0.0;
  for (const double x : inputs(low, high)) {
    const double error = ulps(function(x), reference(static_cast<long double>(x)));
    if (error > worst) {
      worst = error;
      where = x;
    }
  }
  ::testing::Test::RecordProperty(name, std::to_string(worst));
  std::printf("[ ulp      ] %-8s [%g, %g]: %.3f at %.17g\n", name, low, high, worst, where);
  EXPECT_LE(worst, bound) << name << " at x = " << where;
}

TEST(Math, ExpErrorsStayBelowOneUlp) {
  const auto f = [](double x) { return exp(x); };
  const auto r = [](long double x) { return std::exp(x); };
  expect_ulps("exp", 1.0, -700.0, 709.7, f, r);
  expect_ulps("exp", 1.0, -2.0, 2.0, f, r);
  expect_ulps("exp", 2.0, -745.0, -708.0, f, r);  // denormal results
}

TEST(Math, Expm1ErrorsStayBelowTwoUlp) {
  const auto f = [](double x) { return expm1(x); };
  const auto r = [](long double x) { return std::expm1(x); };
  expect_ulps("expm1", 2.0, -50.0, 709.7, f, r);
  expect_ulps("expm1", 2.0, -1.5, 1.5, f, r);
}

TEST(Math, LogErrorsStayBelowOneUlp) {
  const auto f = [](double x) { return log(x); };
  const auto r = [](long double x) { return std::log(x); };
  expect_ulps("log", 1.0, 1e-300, 10.0, f, r);
  expect_ulps("log", 1.0, 0.7, 1.5, f, r);
  expect_ulps("log", 1.0, 1.0, 1e300, f, r);
  expect_ulps("log", 1.0, 5e-324, 2e-308, f, r);
}

TEST(Math, SineAndCosineErrorsStayBelowOneUlp) {
  for (const double limit : {1.0, 10.0, 1e5, 1e6}) {
    expect_ulps(
        "sin", 1.0, -limit, limit, [](double x) { return sin(x); },
        [](long double x) { return std::sin(x); });
    expect_ulps(
        "cos", 1.0, -limit, limit, [](double x) { return cos(x); },
        [](long double x) { return std::cos(x); });
  }
}

TEST(Math, SineStaysAccurateNextToMultiplesOfHalfPi) {
  double worst = 0.0;
  for (int n = 1; n < 63000; n += 7) {
    const double x = static_cast<double>(n * 1.570796326794896619231321691639751442L);
    worst = std::max(worst, ulps(sin(x), std::sin(static_cast<long double>(x))));
    worst = std::max(worst, ulps(cos(x), std::cos(static_cast<long double>(x))));
  }
  EXPECT_LE(worst, 1.0);
}

TEST(Math, SineOfHugeAnglesIsOffByAtMostAnUlpOfTheAngle) {
  for (const double x : inputs(1e6, 1e15)) {
    const double error =
        static_cast<double>(std::fabs(sin(x) - std::sin(static_cast<long double>(x))));
    ASSERT_LE(error, std::nextafter(x, 1e300) - x + 1e-15) << x;
  }
  for (const double x : {1e17, 1e100, 1e300, -1.7e308}) {
    EXPECT_LE(std::fabs(sin(x)), 1.0);
    EXPECT_LE(std::fabs(cos(x)), 1.0);
  }
}

TEST(Math, TangentErrorsStayBelowTwoAndAHalfUlp) {
  const auto f = [](double x) { return tan(x); };
  const auto r = [](long double x) { return std::tan(x); };
  expect_ulps("tan", 2.5, -1.6, 1.6, f, r);
  expect_ulps("tan", 2.5, -1e6, 1e6, f, r);
}

TEST(Math, Atan2ErrorsStayBelowTwoAndAHalfUlpInAllQuadrants) {
  for (const double other : {1.0, -1.0, 0.37, -123.0, 1e-9, 1e200}) {
    expect_ulps(
        "atan2", 2.5, -1000.0, 1000.0, [other](double y) { return atan2(y, other); },
        [other](long double y) { return std::atan2(y, static_cast<long double>(other)); });
    expect_ulps(
        "atan2", 2.5, -1000.0, 1000.0, [other](double x) { return atan2(other, x); },
        [other](long double x) { return std::atan2(static_cast<long double>(other), x); });
  }
}

TEST(Math, ArcSineAndCosineErrorsStayBelowThreeUlp) {
  expect_ulps(
      "asin", 3.0, -1.0, 1.0, [](double x) { return asin(x); },
      [](long double x) { return std::asin(x); });
  expect_ulps(
      "acos", 3.0, -1.0, 1.0, [](double x) { return acos(x); },
      [](long double x) { return std::acos(x); });
}

TEST(Math, ExactOperationsAgreeWithLibm) {
  std::vector<double> all = inputs(-1e6, 1e6);
  for (const double x : {0.0, -0.0, 0.5, -0.5, 1.5, 2.5, -2.5, 4503599627370495.5, 9e15, -9e15,
                         1e300, -1e300, 5e-324, kInfinity, -kInfinity}) {
    all.push_back(x);
  }
  for (const double x : all) {
    ASSERT_EQ(bit_cast_word(round_half_even(x)), bit_cast_word(std::nearbyint(x))) << x;
    ASSERT_EQ(bit_cast_word(floor(x)), bit_cast_word(std::floor(x))) << x;
    ASSERT_EQ(bit_cast_word(abs(x)), bit_cast_word(std::fabs(x))) << x;
    ASSERT_EQ(bit_cast_word(copysign(2.0, x)), bit_cast_word(std::copysign(2.0, x))) << x;
    ASSERT_EQ(sqrt(abs(x)), std::sqrt(std::fabs(x))) << x;
  }
  EXPECT_TRUE(is_nan(sqrt(-1.0)));
  EXPECT_TRUE(std::isnan(floor(kNan)) && std::isnan(round_half_even(kNan)));
}

TEST(Math, WrapAngleStaysInTheHalfOpenTurnAndKeepsTheAngle) {
  for (const double x : inputs(-1e6, 1e6)) {
    const double wrapped = wrap_angle(x);
    ASSERT_GT(wrapped, -kPi);
    ASSERT_LE(wrapped, kPi);
    ASSERT_NEAR(std::sin(wrapped), std::sin(x), 1e-14) << x;
    ASSERT_NEAR(std::cos(wrapped), std::cos(x), 1e-14) << x;
  }
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_EQ(wrap_angle(0.25), 0.25);
  EXPECT_LT(wrap_angle(kPi + 1e-12), 0.0);
  EXPECT_TRUE(std::isnan(wrap_angle(kInfinity)));
}

TEST(Math, SpecialValuesFollowIeee754) {
  EXPECT_EQ(exp(0.0), 1.0);
  EXPECT_EQ(exp(kInfinity), kInfinity);
  EXPECT_EQ(exp(-kInfinity), 0.0);
  EXPECT_EQ(exp(709.79), kInfinity);
  EXPECT_EQ(exp(-745.2), 0.0);
  EXPECT_EQ(expm1(-1e6), -1.0);
  EXPECT_EQ(expm1(5e-324), 5e-324);
  EXPECT_TRUE(std::signbit(expm1(-0.0)));
  EXPECT_EQ(log(1.0), 0.0);
  EXPECT_EQ(log(0.0), -kInfinity);
  EXPECT_EQ(log(-0.0), -kInfinity);
  EXPECT_EQ(log(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(log(-1.0)));
  EXPECT_TRUE(std::isnan(log(-kInfinity)));
  EXPECT_TRUE(std::signbit(sin(-0.0)));
  EXPECT_EQ(sin(5e-324), 5e-324);
  EXPECT_EQ(cos(0.0), 1.0);
  for (const double x : {kInfinity, -kInfinity, kNan}) {
    EXPECT_TRUE(std::isnan(sin(x)) && std::isnan(cos(x)) && std::isnan(tan(x)));
  }
  EXPECT_TRUE(std::isnan(exp(kNan)) && std::isnan(expm1(kNan)) && std::isnan(log(kNan)));
  EXPECT_TRUE(std::isnan(asin(1.0000001)) && std::isnan(acos(-1.0000001)));
  EXPECT_EQ(acos(1.0), 0.0);
  EXPECT_EQ(acos(-1.0), kPi);
  EXPECT_EQ(asin(1.0), kHalfPi);
  EXPECT_TRUE(std::isnan(clamp(kNan, 0.0, 1.0)));
  EXPECT_FALSE(is_finite(kInfinity) || is_finite(kNan));
  EXPECT_TRUE(is_finite(kLargest));
}

TEST(Math, Atan2TreatsZerosInfinitiesAndExtremesAsC) {
  const double values[] = {0.0,        -0.0,   1.0,    -1.0,  kInfinity,
                           -kInfinity, 5e-324, 1e-310, 1e308, -1.7e308};
  for (const double y : values) {
    for (const double x : values) {
      const double expected = std::atan2(y, x);
      EXPECT_EQ(std::signbit(atan2(y, x)), std::signbit(expected)) << y << ", " << x;
      EXPECT_NEAR(atan2(y, x), expected, std::fabs(expected) * 4e-16) << y << ", " << x;
    }
    EXPECT_TRUE(std::isnan(atan2(y, kNan)) && std::isnan(atan2(kNan, y)));
  }
}

}  // namespace
}  // namespace skybody
