// Errors of the float functions over their ranges, against the C library in double.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>

#include "learn/network/kernels/kernels.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

using Loop = void (*)(const float*, float*, std::size_t);

/// Floats from `low` to `high`, both of one sign and not zero, every `step`th.
std::vector<float> floats_between(float low, float high, std::uint32_t step) {
  const auto a = std::bit_cast<std::uint32_t>(low), b = std::bit_cast<std::uint32_t>(high);
  std::vector<float> values;
  for (std::uint32_t bits = std::min(a, b); bits <= std::max(a, b); bits += step) {
    values.push_back(std::bit_cast<float>(bits));
  }
  return values;
}

/// The greatest error in units in the last place of the true value.
double worst_ulp(Loop loop, const std::vector<float>& x, const std::function<double(double)>& f) {
  std::vector<float> y(x.size());
  loop(x.data(), y.data(), x.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double wanted = f(static_cast<double>(x[i]));
    const double ulp = std::ldexp(1.0, std::max(std::ilogb(wanted), -126) - 23);
    worst = std::max(worst, std::abs(static_cast<double>(y[i]) - wanted) / ulp);
  }
  return worst;
}

TEST(FloatFunctions, TanhIsWithinFiveUlp) {
  for (const Isa isa : isas()) {
    const auto tanh = kernels_of(isa).tanh;
    const auto wanted = [](double x) { return std::tanh(x); };
    EXPECT_LE(worst_ulp(tanh, floats_between(1e-30f, 100.0f, 997), wanted), 5.0) << name(isa);
    EXPECT_LE(worst_ulp(tanh, floats_between(-1e-30f, -100.0f, 997), wanted), 5.0) << name(isa);
  }
}

TEST(FloatFunctions, ExpIsWithinTwoUlp) {
  for (const Isa isa : isas()) {
    const auto exp = kernels_of(isa).exp;
    const auto wanted = [](double x) { return std::exp(x); };
    EXPECT_LE(worst_ulp(exp, floats_between(1e-9f, 88.0f, 499), wanted), 2.0) << name(isa);
    EXPECT_LE(worst_ulp(exp, floats_between(-1e-9f, -87.0f, 499), wanted), 2.0) << name(isa);
  }
}

TEST(FloatFunctions, LogIsWithinThreeUlp) {
  for (const Isa isa : isas()) {
    const auto log = kernels_of(isa).log;
    const auto wanted = [](double x) { return std::log(x); };
    EXPECT_LE(worst_ulp(log, floats_between(0x1p-126f, 3e38f, 1999), wanted), 3.0) << name(isa);
    EXPECT_LE(worst_ulp(log, floats_between(0.98f, 1.02f, 1), wanted), 3.0) << name(isa);
  }
}

TEST(FloatFunctions, StayWithinTheirBoundsAtTheEnds) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float x[] = {-infinity, -100.0f, 0.0f, -0.0f, 100.0f, infinity};
  float y[6];
  for (const Isa isa : isas()) {
    kernels_of(isa).tanh(x, y, 6);
    EXPECT_EQ(y[0], -1.0f);
    EXPECT_EQ(y[1], -1.0f);
    EXPECT_EQ(y[2], 0.0f);
    EXPECT_TRUE(std::signbit(y[3]));
    EXPECT_EQ(y[5], 1.0f);
    kernels_of(isa).exp(x, y, 6);
    EXPECT_EQ(y[0], y[1]);
    EXPECT_EQ(y[2], 1.0f);
    EXPECT_TRUE(std::isfinite(y[5]));
  }
}

TEST(FloatFunctions, KeepNaNs) {
  const float x = std::nanf("");
  for (const Isa isa : isas()) {
    for (const Loop loop : {kernels_of(isa).tanh, kernels_of(isa).exp}) {
      float y = 0.0f;
      loop(&x, &y, 1);
      EXPECT_TRUE(std::isnan(y)) << name(isa);
    }
  }
}

TEST(FloatFunctions, GiveTheSameBitsForAnyLengthAndEverySetWithFusedMultiplyAdd) {
  std::vector<float> x = floats_between(0.01f, 10.0f, 1000003);
  for (const auto member : {&KernelTable::tanh, &KernelTable::exp, &KernelTable::log}) {
    std::vector<float> wanted;
    for (const Isa isa : fused_isas()) {
      std::vector<float> whole(x.size()), single(x.size());
      (kernels_of(isa).*member)(x.data(), whole.data(), x.size());
      for (std::size_t i = 0; i < x.size(); ++i) (kernels_of(isa).*member)(&x[i], &single[i], 1);
      EXPECT_EQ(whole, single);
      if (wanted.empty()) wanted = whole;
      EXPECT_EQ(whole, wanted) << name(isa);
    }
  }
}

}  // namespace
}  // namespace skybody::learn
