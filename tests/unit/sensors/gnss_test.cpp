// Satellite navigation: position and velocity of the antenna, noise, wandering bias.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

class GnssTest : public ::testing::Test {
 protected:
  GnssTest() { world.add_quad("quad", 0, 0, 0); }
  PluginWorld world;
};

TEST_F(GnssTest, GivesTheBitsOfDouble) {
  expect_same_bits("gnss", world);
  expect_same_bits("gnss", world,
                   {{"horizontal_noise", 0.5},
                    {"vertical_noise", 1.0},
                    {"velocity_noise", 0.1},
                    {"horizontal_bias", 1.0},
                    {"vertical_bias", 2.0},
                    {"bias_time", 0.01},
                    {"period", 2},
                    {"latency", 3}});
}

TEST_F(GnssTest, ReadsPositionAndVelocityOfTheAntenna) {
  const Instance sensor("gnss", world, {{"position", Numbers{0.5, 0, 0}}});
  EXPECT_EQ(sensor.declared.period, 100) << "10 Hz";
  SensorRun run(sensor);
  run.place(1, 2, 3);
  run.move(4, 5, 6);
  run.spin(0, 0, 2);
  const Numbers& seen = run.sense();
  const Numbers expected{1.5, 2, 3, 4, 6, 6};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(seen[i], expected[i], 1e-14);
}

TEST_F(GnssTest, NoiseIsLargerUpwardsIfAskedFor) {
  const int count = 4000;
  const Instance sensor("gnss", world,
                        {{"horizontal_noise", 0.5}, {"vertical_noise", 1.5}, {"period", 1}});
  EXPECT_NEAR(Spread(readings(sensor, 1, count)).deviation, 0.5, of_deviation(0.5, count));
  EXPECT_NEAR(Spread(readings(sensor, 2, count)).deviation, 1.5, of_deviation(1.5, count));
  EXPECT_EQ(Spread(readings(sensor, 3, 10)).deviation, 0.0);
}

TEST_F(GnssTest, TheBiasIsAStationaryGaussMarkovProcess) {
  const int count = 2000;
  const Instance sensor(
      "gnss", world,
      {{"horizontal_bias", 2.0}, {"vertical_bias", 4.0}, {"bias_time", 0.03}, {"period", 10}});
  Numbers starts, later, products;
  for (std::uint64_t env = 0; env < count; ++env) {
    SensorRun run(sensor, env);
    starts.push_back(run.group.output[2]);
    for (int n = 0; n < 30; ++n) run.step();
    later.push_back(run.group.output[2]);
    products.push_back(starts.back() * later.back() / 16.0);
  }
  EXPECT_NEAR(Spread(starts).deviation, 4.0, of_deviation(4.0, count));
  EXPECT_NEAR(Spread(later).deviation, 4.0, of_deviation(4.0, count));
  // Autocorrelation exp(-1) after bias_time; a product of two normals spreads by sqrt(1 + r^2).
  EXPECT_NEAR(Spread(products).mean, std::exp(-1.0), of_mean(1.07, count));
}

}  // namespace
}  // namespace skybody::testing
