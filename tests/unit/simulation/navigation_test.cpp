// The sensor `ekf` in flight: against the true motion, as consistent as its covariance says, and
// good enough to hover by.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/base/math/quat.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

constexpr double kGravity = 9.81;

/// What the filter says, as its channels follow one another.
struct Estimate {
  Vec3<double> position, velocity, rate;
  Quat<double> rotation;
  std::vector<double> deviation;
  explicit Estimate(const std::vector<double>& all) {
    const double* v = all.data() + all.size() - 22;
    position = {v[0], v[1], v[2]};
    velocity = {v[3], v[4], v[5]};
    rotation = {v[6], v[7], v[8], v[9]};
    rate = {v[10], v[11], v[12]};
    deviation.assign(v + 13, v + 22);
  }
};

/// Hover at (0, 0, 2) without draws, commanded by thrust and torque. @param sensors  the last one
/// is `ekf`
Simulation flight(const std::string& sensors, std::uint64_t seed = 1) {
  Simulation world(
      {.scenario = "hover",
       .overrides = {"sensors=" + sensors, "randomization=[]",
                     "robots[0].controllers=[{plugin: ctbt}]", "robots[0].pose.position=[0, 0, 2]"},
       .seed = seed});
  world.reset();
  return world;
}

/// Thrust and torque towards `goal` with level heading, from the estimate alone.
std::vector<double> steer(const Simulation& world, const Estimate& now, const Vec3<double>& goal) {
  const MassProperties mass = world.mass_properties("quad", "base_link");
  const Vec3<double> pull =
      (goal - now.position) * 4.0 - now.velocity * 3.5 + Vec3<double>{0.0, 0.0, kGravity};
  const Vec3<double> z = pull / norm(pull);
  const Vec3<double> across = cross(z, Vec3<double>{1.0, 0.0, 0.0});
  const Vec3<double> y = across / norm(across), x = cross(y, z);
  const Quat<double> wanted =
      from_rotation(Mat3<double>{{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z}});
  const Quat<double> turn = conjugate(now.rotation) * wanted;
  const double sign = turn.w < 0.0 ? -2.0 : 2.0;
  const Vec3<double> turning =
      Vec3<double>{turn.x, turn.y, turn.z} * (sign * 100.0) - now.rate * 18.0;
  const Vec3<double> up = rotate(now.rotation, Vec3<double>{0.0, 0.0, 1.0});
  return {mass.mass * dot(pull, up), mass.inertia.xx * turning.x, mass.inertia.yy * turning.y,
          mass.inertia.zz * turning.z};
}

/// Flies for `steps` towards goals on a square, calling look(estimate, truth) after each step.
template <class Look>
void fly(Simulation& world, int steps, double side, const Look& look) {
  const Vec3<double> corners[] = {
      {0, 0, 2}, {side, 0, 2}, {side, side, 2.0 + 0.5 * side}, {0, side, 2}};
  for (int n = 0; n < steps; ++n) {
    const Estimate now(world.sensors());
    const std::vector<double> command = steer(world, now, corners[n / 1500 % 4]);
    world.command("quad", command);
    ASSERT_TRUE(world.advance(1));
    look(Estimate(world.sensors()), world.base("quad"));
  }
}

double angle_between(const Quat<double>& a, const Quat<double>& b) {
  const Quat<double> turn = conjugate(a) * b;
  return 2.0 * std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
}

TEST(Navigation, IdealSensorsGiveTheTrueMotion) {
  Simulation world =
      flight("[{plugin: imu}, {plugin: pose}, {plugin: ekf, parameters: {pose: pose}}]");
  fly(world, 6000, 1.0, [](const Estimate& seen, const BodyState& truth) {
    // Integration by 1 ms steps between frames at 125 Hz.
    EXPECT_LT(norm(seen.position - truth.position), 1e-3);
    EXPECT_LT(norm(seen.velocity - truth.velocity), 1e-2);
    EXPECT_LT(angle_between(seen.rotation, truth.rotation), 5e-3);
  });
}

TEST(Navigation, ALateFrameIsComparedWithTheMotionOfItsTime) {
  Simulation world = flight(
      "[{plugin: imu}, {plugin: pose, parameters: {latency: 24}}, {plugin: ekf, parameters: {pose: "
      "pose}}]");
  double worst = 0.0, fastest = 0.0;
  fly(world, 6000, 2.0, [&](const Estimate& seen, const BodyState& truth) {
    worst = std::max(worst, norm(seen.position - truth.position));
    fastest = std::max(fastest, norm(truth.velocity));
  });
  EXPECT_GT(fastest, 1.0);
  // Without the age it lags by 24 ms of flight, 2.4 cm and more.
  EXPECT_LT(worst, 5e-3);
}

TEST(Navigation, HoldsItsPlaceOnTheEstimateWithin5Centimetres) {
  Simulation world = flight(
      "[{plugin: imu, parameters: {preset: bmi088, gyroscope_bias: 0.01}}, {plugin: pose, "
      "parameters: {position_noise: 0.002, rotation_noise: 0.01, latency: 8, dropout: 0.05}}, "
      "{plugin: ekf, parameters: {pose: pose}}]");
  double worst = 0.0;
  int n = 0;
  fly(world, 12000, 0.0, [&](const Estimate&, const BodyState& truth) {
    if (++n > 2000) worst = std::max(worst, norm(truth.position - Vec3<double>{0, 0, 2}));
  });
  EXPECT_LT(worst, 0.05);
}

constexpr double kHorizontalNoise = 0.5, kVerticalNoise = 1.0, kVelocityNoise = 0.1;  // m, m/s

/// A flight by satellites, all of whose errors are as the filter assumes.
Simulation noisy_flight(std::uint64_t seed) {
  return flight(
      "[{plugin: imu, parameters: {accelerometer_noise: 0.01, gyroscope_noise: 0.001, "
      "accelerometer_bias: 0.2, gyroscope_bias: 0.02, accelerometer_walk: 0.001, "
      "gyroscope_walk: 0.0001}}, {plugin: gnss, parameters: {horizontal_noise: 0.5, "
      "vertical_noise: 1.0, velocity_noise: 0.1}}, {plugin: barometer, parameters: {noise: "
      "3.6}}, {plugin: magnetometer, parameters: {noise: 1}}, {plugin: ekf, parameters: {gnss: "
      "gnss, barometer: barometer, magnetometer: magnetometer, initial_rotation: 0.1}}]",
      seed);
}

TEST(Navigation, ErrorsAreAsLargeAsTheCovarianceSays) {
  double square = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Simulation world = noisy_flight(seed);
    int n = 0;
    fly(world, 6000, 2.0, [&](const Estimate& seen, const BodyState& truth) {
      if (++n % 500 != 0 || n < 1500) return;  // one sample for each half second
      const Vec3<double> wrong = seen.position - truth.position;
      const double errors[3] = {wrong.x / seen.deviation[0], wrong.y / seen.deviation[1],
                                wrong.z / seen.deviation[2]};
      for (const double e : errors) square += e * e;
      count += 3;
    });
  }
  // Errors of neighbouring samples depend on one another: about 60 independent ones, whose mean
  // square is 1 +- 0.18.
  EXPECT_NEAR(square / count, 1.0, 0.5);
}

/// A fix of satellites against the estimate one step before: the squares of the differences, over
/// the variances that the filter expects.
struct Innovation {
  double position = 0.0, velocity = 0.0;  ///< sums over x, y and z

  Innovation(const Estimate& before, const double* fix) {
    constexpr double kStep = 1e-3;  // s
    const Vec3<double> place = before.position + before.velocity * kStep;
    const double expected[] = {place.x,           place.y,           place.z,
                               before.velocity.x, before.velocity.y, before.velocity.z};
    const double noise[] = {kHorizontalNoise, kHorizontalNoise, kVerticalNoise,
                            kVelocityNoise,   kVelocityNoise,   kVelocityNoise};
    for (std::size_t k = 0; k < 6; ++k) {
      const double wrong = fix[k] - expected[k];
      const double variance = before.deviation[k] * before.deviation[k] + noise[k] * noise[k];
      (k < 3 ? position : velocity) += wrong * wrong / variance;
    }
  }
};

TEST(Navigation, InnovationsAreAsLargeAsTheFilterExpects) {
  constexpr std::size_t kFix = 6, kStamp = 12;  // of the channels: behind the IMU's six
  double position = 0.0, velocity = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Simulation world = noisy_flight(seed);
    Estimate before(world.sensors());
    double stamp = 0.0;
    fly(world, 6000, 2.0, [&](const Estimate& seen, const BodyState&) {
      const std::vector<double> all = world.sensors();
      if (all[kStamp] != stamp) {
        const Innovation found(before, &all[kFix]);
        position += found.position;
        velocity += found.velocity;
        count += 3;
      }
      stamp = all[kStamp];
      before = seen;
    });
  }
  ASSERT_GT(count, 1350);
  // Innovations of a consistent filter are independent: of 1,350 the mean square is 1 +- 0.039, and
  // three times that are allowed.
  EXPECT_NEAR(position / count, 1.0, 0.12);
  EXPECT_NEAR(velocity / count, 1.0, 0.12);
}

}  // namespace
}  // namespace skybody
