// The IMU against hand calculation: rest, free fall, circle, mounting, noise, bias, rate, latency.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

class ImuTest : public ::testing::Test {
 protected:
  ImuTest() { world.add_quad("quad"); }

  /// Resets, then evaluates the sensor once, as in the engine.
  static Group begin(const Instance& imu) {
    Group g = imu.group(1);
    imu.call(Call::kReset, g);
    imu.call(Call::kSense, g);
    return g;
  }
  /// One physics step with velocity `v` of the base's origin after it; evaluates the sensor when
  /// due.
  static void step(const Instance& imu, Group& g, const std::vector<double>& v) {
    g.before = g.bodies;
    for (std::size_t k = 0; k < 3; ++k) g.bodies[7 + k] = v[k];
    if (++g.physics_step[0] % static_cast<std::uint64_t>(imu.declared.period) == 0)
      imu.call(Call::kSense, g);
  }
  static void turn(std::vector<double>& bodies, double yaw) {
    bodies[3] = std::cos(0.5 * yaw);
    bodies[6] = std::sin(0.5 * yaw);
  }
  PluginWorld world;
};

TEST_F(ImuTest, GivesTheBitsOfDouble) {
  expect_same_bits("imu", world);
  expect_same_bits("imu", world,
                   {{"accelerometer_noise", 0.01},
                    {"gyroscope_walk", 0.1},
                    {"gyroscope_bias", 0.1},
                    {"latency", 3},
                    {"period", 2}});
}

TEST_F(ImuTest, ReadsGravityAtRest) {
  const Instance imu("imu", world);
  Group g = begin(imu);
  EXPECT_EQ(g.output, (std::vector<double>{0, 0, 9.81, 0, 0, 0}));
  step(imu, g, {0, 0, 0});
  EXPECT_EQ(g.output, (std::vector<double>{0, 0, 9.81, 0, 0, 0}));
}

TEST_F(ImuTest, ReadsTheGravityOfItsEnvironment) {
  const Instance imu("imu", world);
  Group g = imu.group(1);
  g.params[2] = -1.62;
  imu.call(Call::kReset, g);
  imu.call(Call::kSense, g);
  EXPECT_EQ(g.output, (std::vector<double>{0, 0, 1.62, 0, 0, 0}));
}

TEST_F(ImuTest, ReadsNothingInFreeFall) {
  const Instance imu("imu", world);
  Group g = begin(imu);
  for (int n = 1; n <= 5; ++n) {
    step(imu, g, {0, 0, -9.81 * 0.001 * n});
    for (const double f : g.output) EXPECT_NEAR(f, 0.0, 1e-12);
  }
}

TEST_F(ImuTest, ReadsCentripetalAccelerationOnACircle) {
  // Base at radius 2 m, 3 rad/s, nose along the velocity: +y of the body points to the centre.
  const Instance imu("imu", world);
  Group g = begin(imu);
  const double w = 3.0, r = 2.0;
  for (int n = 0; n <= 3; ++n) {
    const double a = w * 0.001 * n;
    if (n == 0) {
      g.bodies[7] = r * w;
      g.bodies[12] = w;
      continue;
    }
    g.before = g.bodies;
    turn(g.bodies, a);
    g.bodies[7] = r * w * std::cos(a);
    g.bodies[8] = r * w * std::sin(a);
    ++g.physics_step[0];
    imu.call(Call::kSense, g);
    // the mean over the step lags by half a step: v^2/r up to (w dt)^2/6, rotated by w dt/2
    EXPECT_NEAR(g.output[1], r * w * w, r * w * w * 1e-5);
    EXPECT_NEAR(g.output[0], 0.5 * w * 0.001 * r * w * w, 1e-4);
    EXPECT_NEAR(g.output[2], 9.81, 1e-12);
    EXPECT_NEAR(g.output[5], w, 1e-15);
  }
}

TEST_F(ImuTest, AnArmTurnsWithTheBody) {
  const Instance imu("imu", world, {{"position", std::vector<double>{0.5, 0, 0}}});
  Group g = begin(imu);
  g.bodies[12] = 4.0;
  g.before = g.bodies;
  turn(g.bodies, 0.004);
  ++g.physics_step[0];
  imu.call(Call::kSense, g);
  EXPECT_NEAR(g.output[0], -0.5 * 16.0, 1e-3);
}

TEST_F(ImuTest, MountingTurnsTheAxes) {
  const Instance imu("imu", world, {{"orientation", std::vector<double>{3.141592653589793, 0, 0}}});
  Group g = begin(imu);
  EXPECT_NEAR(g.output[2], -9.81, 1e-14);
}

TEST_F(ImuTest, NoiseHasTheDensityGiven) {
  const Instance imu("imu", world, {{"accelerometer_noise", 0.02}, {"period", 4}});
  Group g = begin(imu);
  const double sigma = 0.02 / std::sqrt(0.004);
  double sum = 0, squares = 0;
  const int count = 20000;
  for (int n = 0; n < count; ++n) {
    for (int k = 0; k < 4; ++k) step(imu, g, {0, 0, 0});
    sum += g.output[0];
    squares += g.output[0] * g.output[0];
    EXPECT_EQ(g.output[3], 0.0);
  }
  EXPECT_NEAR(sum / count, 0.0, 5.0 * sigma / std::sqrt(count));  // 5 standard errors
  EXPECT_NEAR(squares / count / (sigma * sigma), 1.0, 5.0 * std::sqrt(2.0 / count));
}

TEST_F(ImuTest, BiasWalksWithTheSquareRootOfTime) {
  const Instance imu("imu", world, {{"gyroscope_walk", 0.5}});
  const int runs = 2000, steps = 100;
  double squares = 0;
  for (int run = 0; run < runs; ++run) {
    Group g = imu.group(1);
    g.key[1] = static_cast<std::uint64_t>(run);
    imu.call(Call::kReset, g);
    imu.call(Call::kSense, g);
    EXPECT_EQ(g.output[4], 0.0);
    for (int n = 0; n < steps; ++n) step(imu, g, {0, 0, 0});
    squares += g.output[4] * g.output[4];
  }
  EXPECT_NEAR(squares / runs / (0.25 * 0.001 * steps), 1.0, 5.0 * std::sqrt(2.0 / runs));
}

TEST_F(ImuTest, InitialBiasIsDrawnOncePerEpisode) {
  const Instance imu("imu", world, {{"accelerometer_bias", 0.3}});
  double squares = 0;
  const int runs = 4000;
  for (int run = 0; run < runs; ++run) {
    Group g = imu.group(1);
    g.episode[0] = static_cast<std::uint64_t>(run + 1);
    imu.call(Call::kReset, g);
    imu.call(Call::kSense, g);
    const double first = g.output[0];
    if (run < 10) {
      step(imu, g, {0, 0, 0});
      EXPECT_EQ(g.output[0], first);
    }
    squares += first * first;
  }
  EXPECT_NEAR(squares / runs / 0.09, 1.0, 5.0 * std::sqrt(2.0 / runs));
}

TEST_F(ImuTest, LatencyIsExact) {
  for (const int latency : {1, 3, 8}) {
    const Instance imu("imu", world, {{"latency", latency}});
    Group g = begin(imu);
    for (int n = 1; n <= 30; ++n) {
      step(imu, g, {0.001 * 0.5 * n * (n + 1), 0, 0});  // acceleration n in step n
      const int seen = n - latency;
      EXPECT_NEAR(g.output[0], seen >= 1 ? seen : 0, 1e-9)
          << "latency " << latency << ", step " << n;
    }
  }
}

TEST_F(ImuTest, SamplesAtItsRateAndDeliversLater) {
  const Instance imu("imu", world, {{"period", 4}, {"latency", 2}});
  EXPECT_EQ(imu.declared.period, 2);
  Group g = begin(imu);
  for (int n = 1; n <= 30; ++n) {
    step(imu, g, {0.001 * 0.5 * n * (n + 1), 0, 0});
    const int sampled = n >= 6 ? (n - 2) / 4 * 4 : 0;  // at 4, 8, ..; visible from 6, 10, .. on
    EXPECT_NEAR(g.output[0], sampled, 1e-9) << n;
  }
}

TEST_F(ImuTest, RunsAtEveryPeriodOnly) {
  const Instance imu("imu", world, {{"period", 5}});
  EXPECT_EQ(imu.declared.period, 5);
  EXPECT_EQ(imu.declared.buffer_words, 0);
  EXPECT_TRUE(imu.declared.needs_bodies_before);
}

TEST_F(ImuTest, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("imu", world, {{"link", "tail"}}),
              HasSubstr("has no link `tail`: there are base"));
  EXPECT_THAT(refusal("imu", world, {{"robot", "quda"}}),
              HasSubstr("no robot `quda`: there are quad"));
  world.add_quad("other");
  EXPECT_THAT(refusal("imu", world, {}), HasSubstr("several robots: name one of quad, other"));
}

}  // namespace
}  // namespace skybody::testing
