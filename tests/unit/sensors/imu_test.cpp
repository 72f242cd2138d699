// The IMU against hand calculation: rest, free fall, circle, mounting, noise, bias, rate, latency.
#include <cmath>

#include "tests/unit/sensors/sensor_run.h"

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
  expect_same_bits("imu", world, {{"preset", "adis16448"}});
  expect_same_bits("imu", world,
                   {{"accelerometer_scale", Numbers{0.1, -0.1, 0.2}},
                    {"gyroscope_misalignment", Numbers{0.01, 0.02, 0.03}},
                    {"g_sensitivity", Numbers{0.1, 0.2, 0.3}},
                    {"gyroscope_instability", 0.1},
                    {"gyroscope_range", 3.0},
                    {"accelerometer_resolution", 0.25},
                    {"phase", 1},
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
  EXPECT_EQ(imu.declared.memory.buffer_words, 0);
  EXPECT_TRUE(imu.declared.needs_bodies_before);
}

TEST_F(ImuTest, SaturatesAndRounds) {
  const Instance imu(
      "imu", world,
      {{"accelerometer_range", 9.0}, {"gyroscope_resolution", 0.5}, {"gyroscope_range", 2.0}});
  Group g = begin(imu);
  EXPECT_EQ(g.output[2], 9.0) << "g is beyond the range";
  g.before = g.bodies;
  g.bodies[10] = 0.7, g.bodies[11] = -0.8, g.bodies[12] = -7.0;
  ++g.physics_step[0];
  imu.call(Call::kSense, g);
  EXPECT_EQ(g.output[3], 0.5);
  EXPECT_EQ(g.output[4], -1.0);
  EXPECT_EQ(g.output[5], -2.0);
}

TEST_F(ImuTest, ScaleAndMisalignmentActOnTheTrueValue) {
  const Instance imu("imu", world,
                     {{"accelerometer_scale", Numbers{0.0, 0.0, 0.02}},
                      {"accelerometer_misalignment", Numbers{0.01, 0.0, 0.0}},
                      {"gyroscope_scale", Numbers{-0.1, 0.0, 0.0}},
                      {"gyroscope_misalignment", Numbers{0.0, 0.0, 0.02}}});
  Group g = imu.group(1);
  g.bodies[10] = 2.0;
  g.before = g.bodies;
  imu.call(Call::kReset, g);
  imu.call(Call::kSense, g);
  // Axes turned by 0.01 rad about x see g along y, too; seen = v + v x misalignment.
  EXPECT_NEAR(g.output[1], 9.81 * 0.01, 1e-12);
  EXPECT_NEAR(g.output[2], 9.81 * 1.02, 1e-12);
  EXPECT_NEAR(g.output[3], 1.8, 1e-12);
  EXPECT_NEAR(g.output[4], -0.04, 1e-12);
}

TEST_F(ImuTest, GSensitivityAddsRateInProportionToForce) {
  const Instance imu("imu", world, {{"g_sensitivity", Numbers{0.0, 0.0, 2e-4}}});
  EXPECT_NEAR(begin(imu).output[5], 9.81 * 2e-4, 1e-15);
}

/// Allan variance of `samples`, averaged over clusters of `m` (overlapping).
double allan_variance(const Numbers& samples, std::size_t m) {
  Numbers sums{0.0};
  for (const double x : samples) sums.push_back(sums.back() + x);
  double square = 0.0;
  const std::size_t count = samples.size() - 2 * m + 1;
  for (std::size_t k = 0; k < count; ++k) {
    const double change = (sums[k + 2 * m] - 2.0 * sums[k + m] + sums[k]) / static_cast<double>(m);
    square += change * change;
  }
  return 0.5 * square / static_cast<double>(count);
}

TEST_F(ImuTest, AllanVarianceIsThatOfNoiseWalkAndInstability) {
  world.dt = 0.01;
  const int count = 200000;
  const double noise = 0.02, walk = 0.05, instability = 0.3, time = 0.5;
  const Instance white("imu", world, {{"gyroscope_noise", noise}});
  const Instance walking("imu", world, {{"gyroscope_walk", walk}});
  const Instance unstable("imu", world,
                          {{"gyroscope_instability", instability}, {"instability_time", time}});
  const Numbers of_noise = readings(white, 3, count), of_walk = readings(walking, 4, count),
                of_instability = readings(unstable, 5, count);
  for (const std::size_t m : {10u, 40u, 95u, 200u}) {
    const double tau = world.dt * static_cast<double>(m), ratio = tau / time;
    // Woodman, and IEEE Std 952: N^2 / tau, K^2 tau / 3, and a Gauss-Markov process.
    const double process =
        2.0 * instability * instability / ratio *
        (1.0 - (3.0 - 4.0 * std::exp(-ratio) + std::exp(-2.0 * ratio)) / (2.0 * ratio));
    // The variance of an overlapping estimate over n clusters is below 3 / n of its square; four
    // standard errors. A discrete walk differs from K^2 tau / 3 by (1 + 1 / (2 m^2)).
    const double error = 4.0 * std::sqrt(3.0 * static_cast<double>(m) / count);
    EXPECT_NEAR(allan_variance(of_noise, m) / (noise * noise / tau), 1.0, error) << m;
    EXPECT_NEAR(allan_variance(of_walk, m) / (walk * walk * tau / 3.0), 1.0, error + 0.005) << m;
    // Samples of the process, in place of its means over dt, add less than dt / time.
    EXPECT_NEAR(allan_variance(of_instability, m) / process, 1.0, error + world.dt / time) << m;
  }
}

TEST_F(ImuTest, APresetHasTheErrorsOfItsDatasheet) {
  constexpr double kG = 9.80665, kDegree = 3.141592653589793 / 180.0;
  const Instance imu("imu", world, {{"preset", "icm42688"}});
  const int count = 20000;
  const double rate = 0.0028 * kDegree / std::sqrt(world.dt);
  const double force = 65e-6 * kG / std::sqrt(world.dt);
  // Rounding to a multiple of r adds a variance of r^2 / 12.
  const double step = kDegree / 16.4, coarse = kG / 2048.0;
  const double seen = std::sqrt(rate * rate + step * step / 12.0);
  const double seen_force = std::sqrt(force * force + coarse * coarse / 12.0);
  const Numbers rates = readings(imu, 3, count), forces = readings(imu, 0, count);
  EXPECT_NEAR(Spread(rates).deviation, seen, of_deviation(seen, count) + 0.02 * seen);
  EXPECT_NEAR(Spread(forces).deviation, seen_force,
              of_deviation(seen_force, count) + 0.02 * seen_force);
  EXPECT_NEAR(std::remainder(rates[0], step), 0.0, 1e-12);
}

TEST_F(ImuTest, AGivenOrDrawnErrorReplacesThePresets) {
  const Instance given("imu", world,
                       {{"preset", "bmi088"},
                        {"gyroscope_noise", 0.0},
                        {"gyroscope_instability", 0.0},
                        {"gyroscope_resolution", 0.0}});
  EXPECT_EQ(Spread(readings(given, 3, 10)).deviation, 0.0);
  const Instance drawn("imu", world, {{"preset", "bmi088"}, {"gyroscope_resolution", 0.0}});
  const auto noise = static_cast<std::size_t>(drawn.env_param("gyroscope_noise"));
  Numbers rates;
  SensorRun run(drawn);
  run.group.params[noise] = 0.1;  // far within the range
  for (int n = 0; n < 1000; ++n) {
    run.step();
    rates.push_back(run.group.output[3]);
  }
  const double deviation = 0.1 / std::sqrt(world.dt);
  EXPECT_NEAR(Spread(rates).deviation, deviation, of_deviation(deviation, 1000));
}

TEST_F(ImuTest, TheBasicUnitHasNoMoreWordsThanBefore) {
  const Instance imu("imu", world);
  EXPECT_EQ(imu.plugin().state_words, 13u);
  EXPECT_EQ(imu.declared.memory.buffer_words, 0);
  EXPECT_TRUE(imu.declared.sensor.is_only_when_read);
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
