// Jets: derivatives against known closed forms, and their bits in packs.
#include "core/base/math/jet.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/math/random.h"
#include "core/base/simd/pack.h"

namespace skybody {
namespace {

using J = Jet<double, 5>;

/// t = 0.7 + s, as a jet in s.
const J kTime = J::variable(0.7, 1.0);

void expect_derivatives(const J& jet, std::initializer_list<double> wanted) {
  int k = 0;
  for (const double value : wanted) {
    EXPECT_NEAR(jet.derivative(k), value, 1e-13 * (1.0 + std::abs(value))) << "derivative " << k;
    ++k;
  }
}

TEST(Jet, ProductsAndConstants) {
  // t^3 - 2 t + 5
  expect_derivatives(kTime * kTime * kTime - 2.0 * kTime + 5.0,
                     {std::pow(0.7, 3) - 1.4 + 5.0, 3 * 0.49 - 2.0, 6 * 0.7, 6.0, 0.0});
}

TEST(Jet, QuotientsAreInverseProducts) {
  // 1 / t has derivatives (-1)^k k! / t^(k+1)
  const double t = 0.7;
  expect_derivatives(1.0 / kTime, {1 / t, -1 / (t * t), 2 / std::pow(t, 3), -6 / std::pow(t, 4),
                                   24 / std::pow(t, 5)});
  const J whole = (kTime * kTime) / kTime;
  expect_derivatives(whole, {0.7, 1.0, 0.0, 0.0, 0.0});
}

TEST(Jet, RootsSquareToTheirArgument) {
  const J a = kTime * kTime + 3.0, root = sqrt(a), back = root * root;
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(back.c[k], a.c[k], 1e-14);
}

TEST(Jet, SineAndCosineTurnIntoOneAnother) {
  const SinCos<J> of = sincos(2.0 * kTime);
  const double s = std::sin(1.4), c = std::cos(1.4);
  expect_derivatives(of.sin, {s, 2 * c, -4 * s, -8 * c, 16 * s});
  expect_derivatives(of.cos, {c, -2 * s, -4 * c, 8 * s, 16 * c});
}

TEST(Jet, PacksGiveTheBitsOfDouble) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random<double> random(RandomKey{1, 2}, 0, i, 3);
    const double value = random.uniform(0.5, 3.0), rate = random.uniform(-2.0, 2.0);
    const auto f = [](const auto& t) { return sincos(t / sqrt(t * t + 1.0)).sin * t; };
    const J one = f(J::variable(value, rate));
    const auto many = f(Jet<Pack<2>, 5>::variable(Pack<2>(value), Pack<2>(rate)));
    for (int k = 0; k < 5; ++k) EXPECT_EQ(many.c[k].v[1], one.c[k]);
  }
}

}  // namespace
}  // namespace skybody
