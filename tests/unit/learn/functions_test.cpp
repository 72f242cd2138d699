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

/// The largest error in ulp of the true value.
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

/// Box and Muller's two normals for a pair of words, in double. The uniform number is rounded to
/// float once, as in the kernel.
std::pair<double, double> normals_of(std::uint32_t radius, std::uint32_t angle) {
  const double u = std::ldexp(static_cast<float>(radius + 0.5), -32);
  const double r = std::sqrt(-2.0 * std::log(u));
  const double eighth = std::acos(-1.0) / 4.0;
  const int quadrant = static_cast<int>(angle >> 30);
  const double part = std::ldexp(static_cast<double>(angle & 0x3fffffffu), -29) - 1.0;
  const double turn = eighth * (2.0 * quadrant + part);
  return {r * std::cos(turn), r * std::sin(turn)};
}

TEST(FloatFunctions, NormalsAreWithinEightUlpOfTheirRadius) {
  // Error bounds: logarithm 3 ulp, halved by the root; sine 2, angle 2, products 2.
  std::vector<std::uint32_t> radius, angle;
  for (std::uint64_t word = 0; word < (std::uint64_t{1} << 32); word += 12582907) {
    for (const std::uint32_t near : {0u, 1u, 1000u}) {
      radius.push_back(static_cast<std::uint32_t>(word) ^ near);
      angle.push_back(static_cast<std::uint32_t>(word * 7919 + near));
    }
  }
  radius.resize(radius.size() / 16 * 16);
  std::vector<float> y(2 * radius.size());
  for (const Isa isa : isas()) {
    kernels_of(isa).normals(radius.data(), angle.data(), y.data(), radius.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < radius.size(); ++i) {
      const auto [cosine, sine] = normals_of(radius[i], angle[i]);
      const double ulp = std::ldexp(1.0, std::ilogb(std::hypot(cosine, sine)) - 23);
      const float* found = y.data() + i / 16 * 32 + i % 16;
      worst = std::max({worst, std::abs(static_cast<double>(found[0]) - cosine) / ulp,
                        std::abs(static_cast<double>(found[16]) - sine) / ulp});
    }
    EXPECT_LE(worst, 8.0) << name(isa);
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
  }
}

TEST(FloatFunctions, KeepNaNs) {
  const float x = std::nanf("");
  for (const Isa isa : isas()) {
    float y = 0.0f;
    kernels_of(isa).tanh(&x, &y, 1);
    EXPECT_TRUE(std::isnan(y)) << name(isa);
  }
}

TEST(FloatFunctions, GiveTheSameBitsForAnyLengthAndEverySetWithFusedMultiplyAdd) {
  std::vector<float> x = floats_between(0.01f, 10.0f, 1000003);
  std::vector<float> wanted;
  for (const Isa isa : fused_isas()) {
    const auto tanh = kernels_of(isa).tanh;
    std::vector<float> whole(x.size()), single(x.size());
    tanh(x.data(), whole.data(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i) tanh(&x[i], &single[i], 1);
    EXPECT_EQ(whole, single);
    if (wanted.empty()) wanted = whole;
    EXPECT_EQ(whole, wanted) << name(isa);
  }
}

}  // namespace
}  // namespace skybody::learn
