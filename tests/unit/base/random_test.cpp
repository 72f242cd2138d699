// Keyed random numbers: Philox's published answers, the distributions' moments, lanes.
#include "core/base/math/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skybody {
namespace {

// Source: kat_vectors of Random123 1.14 (philox4x64 10).
TEST(Random, PhiloxGivesThePublishedAnswers) {
  Random<double> zeros(RandomKey{0, 0}, 0, 0, 0);
  EXPECT_EQ(zeros.bits(), 0x16554d9eca36314cull);
  EXPECT_EQ(zeros.bits(), 0xdb20fe9d672d0fdcull);
  EXPECT_EQ(zeros.bits(), 0xd7e772cee186176bull);
  EXPECT_EQ(zeros.bits(), 0x7e68b68aec7ba23bull);
  const r123::Philox4x64::ctr_type pi = {
      {0x243f6a8885a308d3ull, 0x13198a2e03707344ull, 0xa4093822299f31d0ull, 0x082efa98ec4e6c89ull}};
  const r123::Philox4x64::key_type key = {{0x452821e638d01377ull, 0xbe5466cf34e90c6cull}};
  const r123::Philox4x64::ctr_type words = philox4x64_R(10, pi, key);
  EXPECT_EQ(words[0], 0xa528f45403e61d95ull);
  EXPECT_EQ(words[3], 0x57bd43b5e52b7fe6ull);
}

TEST(Random, CounterIsEpisodeStreamStepBlock) {
  const r123::Philox4x64::ctr_type counter = {{30, 50, 40, 1}};
  const r123::Philox4x64::key_type key = {{10, 20}};
  const r123::Philox4x64::ctr_type block = philox4x64_R(10, counter, key);
  Random<double> random(RandomKey{10, 20}, 30, 40, 50);
  for (int i = 0; i < 4; ++i) random.bits();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(random.bits(), block[i]);
}

template <int W>
void expect_lanes_like_double() {
  using P = Pack<W>;
  WordPack<W> seed(0), env(0), episode(0), step(0);
  for (int i = 0; i < W; ++i) {
    set_lane(seed, i, 42);
    set_lane(env, i, i);
    set_lane(episode, i, 100 + i / 2);
    set_lane(step, i, 7 * i);
  }
  Random<P> lanes(seed, env, episode, step, derive_stream("wind"));
  const WordPack<W> bits = lanes.bits(), dice = lanes.integer(6);
  const P uniform = lanes.uniform(), range = lanes.uniform(-2.0, 5.0), normal = lanes.normal();
  const Vec3<P> direction = lanes.unit_vector();
  const Quat<P> turn = lanes.quaternion();
  for (int i = 0; i < W; ++i) {
    Random<double> one(42, i, 100 + i / 2, 7 * i, derive_stream("wind"));
    EXPECT_EQ(lane(bits, i), one.bits());
    EXPECT_EQ(lane(dice, i), one.integer(6));
    EXPECT_EQ(lane(uniform, i), one.uniform());
    EXPECT_EQ(lane(range, i), one.uniform(-2.0, 5.0));
    EXPECT_EQ(lane(normal, i), one.normal());
    const Vec3<double> d = one.unit_vector();
    EXPECT_EQ(lane(direction.x, i), d.x);
    EXPECT_EQ(lane(direction.y, i), d.y);
    EXPECT_EQ(lane(direction.z, i), d.z);
    const Quat<double> q = one.quaternion();
    EXPECT_EQ(lane(turn.w, i), q.w);
    EXPECT_EQ(lane(turn.z, i), q.z);
  }
}

TEST(Random, EachLaneDrawsWhatItWouldDrawAlone) {
  expect_lanes_like_double<2>();
  expect_lanes_like_double<4>();
  expect_lanes_like_double<8>();
}

TEST(Random, NormalTakesExactlyTwoUniforms) {
  Random<double> a(RandomKey{1, 2}, 3, 4, 5), b(RandomKey{1, 2}, 3, 4, 5);
  a.normal();
  b.uniform();
  b.uniform();
  EXPECT_EQ(a.bits(), b.bits());
}

TEST(Random, UniformHasTheMomentsOfItsDistribution) {
  Random<double> random(RandomKey{7, 0}, 0, 0, 1);
  const int n = 400000;
  double sum = 0, squares = 0, lag = 0, last = 0.5, low = 1, high = 0;
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += (u - 0.5) * (u - 0.5);
    lag += (u - 0.5) * (last - 0.5);
    last = u;
    low = std::fmin(low, u);
    high = std::fmax(high, u);
  }
  // Five standard errors each.
  EXPECT_NEAR(sum / n, 0.5, 5 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(squares / n, 1.0 / 12, 5 * std::sqrt(1.0 / 180 / n));
  EXPECT_NEAR(lag / n, 0.0, 5 * (1.0 / 12) / std::sqrt(n));
  EXPECT_LT(low, 1e-4);
  EXPECT_GT(high, 1 - 1e-4);
}

TEST(Random, NormalHasTheMomentsOfItsDistribution) {
  Random<double> random(RandomKey{8, 0}, 0, 0, 1);
  const int n = 400000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  int beyond_two = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    m1 += x;
    m2 += x * x;
    m3 += x * x * x;
    m4 += x * x * x * x;
    beyond_two += std::fabs(x) > 2.0;
  }
  EXPECT_NEAR(m1 / n, 0.0, 5 * std::sqrt(1.0 / n));
  EXPECT_NEAR(m2 / n, 1.0, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m3 / n, 0.0, 5 * std::sqrt(15.0 / n));
  EXPECT_NEAR(m4 / n, 3.0, 5 * std::sqrt(96.0 / n));
  EXPECT_NEAR(beyond_two / double{n}, 0.0455003, 5 * std::sqrt(0.0455 / n));
}

TEST(Random, IntegersAreEvenlySpread) {
  Random<double> random(RandomKey{9, 0}, 0, 0, 1);
  int counts[6] = {};
  for (int i = 0; i < 60000; ++i) ++counts[random.integer(6)];
  for (const int count : counts) EXPECT_NEAR(count, 10000, 5 * std::sqrt(60000 * 5.0 / 36));
  EXPECT_EQ(random.integer(1), 0u);
}

TEST(Random, DirectionsAndRotationsHaveNoFavourite) {
  Vec3<double> sum{0, 0, 0}, turned{0, 0, 0};
  const int n = 50000;
  for (int i = 0; i < n; ++i) {
    Random<double> random(RandomKey{10, 0}, 0, i, 1);
    const Vec3<double> v = random.unit_vector();
    ASSERT_NEAR(squared_norm(v), 1.0, 1e-15);
    sum += v;
    turned += rotate(random.quaternion(), Vec3<double>{1, 0, 0});
  }
  const double bound = 5 * std::sqrt(n / 3.0);
  for (const Vec3<double>& s : {sum, turned}) {
    EXPECT_LT(std::fabs(s.x), bound);
    EXPECT_LT(std::fabs(s.y), bound);
    EXPECT_LT(std::fabs(s.z), bound);
  }
}

TEST(Random, EveryPartOfTheKeyMatters) {
  const std::uint64_t base = Random<double>(RandomKey{1, 2}, 3, 4, 5).bits();
  EXPECT_NE(base, Random<double>(RandomKey{2, 2}, 3, 4, 5).bits());
  EXPECT_NE(base, Random<double>(RandomKey{1, 3}, 3, 4, 5).bits());
  EXPECT_NE(base, Random<double>(RandomKey{1, 2}, 4, 4, 5).bits());
  EXPECT_NE(base, Random<double>(RandomKey{1, 2}, 3, 5, 5).bits());
  EXPECT_NE(base, Random<double>(RandomKey{1, 2}, 3, 4, 6).bits());
  EXPECT_EQ(base, Random<double>(RandomKey{1, 2}, 3, 4, 5).bits());
}

// Golden: these bits are promised across releases (no libm function is used).
TEST(Random, GoldenDrawsStay) {
  Random<double> random(RandomKey{2026, 3}, 1, 2, derive_stream("golden"));
  EXPECT_EQ(bit_cast_word(random.uniform()), 0x3fa35bbfd6cceb30ull);
  EXPECT_EQ(bit_cast_word(random.normal()), 0x3fe942ed2c42816cull);
  EXPECT_EQ(bit_cast_word(random.quaternion().w), 0x3fb53a18d8f24d2dull);
}

TEST(Random, StreamNamesHashAsFnv1a) {
  static_assert(derive_stream("") == 0xcbf29ce484222325ull, "");
  static_assert(derive_stream("a") == 0xaf63dc4c8601ec8cull, "");
  static_assert(derive_stream("foobar") == 0x85944171f73967e8ull, "");
  EXPECT_EQ(derive_stream("foobar", 3), derive_stream("foo"));
}

}  // namespace
}  // namespace skybody
