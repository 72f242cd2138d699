// The barometer against the tables of ISO 2533, with noise and drift.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

class BarometerTest : public ::testing::Test {
 protected:
  BarometerTest() { world.add_quad("quad", 0, 0, 0); }

  /// Pressure at a geopotential altitude [m].
  double pressure(double height) {
    constexpr double kRadius = 6356766.0;
    const Instance sensor("barometer", world);
    SensorRun run(sensor);
    run.place(0, 0, kRadius * height / (kRadius - height));
    const Numbers& output = run.sense();
    EXPECT_NEAR(output[1], height, 1e-6) << "the altitude is the inverse: roundings of 1e-10";
    return output[0];
  }
  PluginWorld world;
};

TEST_F(BarometerTest, GivesTheBitsOfDouble) {
  expect_same_bits("barometer", world);
  expect_same_bits("barometer", world,
                   {{"altitude", 500.0},
                    {"noise", 3.0},
                    {"drift", 20.0},
                    {"drift_time", 0.1},
                    {"resolution", 1.0},
                    {"period", 1},
                    {"latency", 2}});
}

TEST_F(BarometerTest, IsThatOfTheStandardAtmosphere) {
  // ISO 2533, table of geopotential altitudes; its entries have six digits.
  EXPECT_NEAR(pressure(0.0), 101325.0, 1e-6);
  EXPECT_NEAR(pressure(1000.0), 89874.6, 0.1);
  EXPECT_NEAR(pressure(5000.0), 54019.9, 0.1);
  EXPECT_NEAR(pressure(10000.0), 26436.3, 0.1);
}

TEST_F(BarometerTest, FallsBy12PascalAMetreNearTheSea) {
  EXPECT_NEAR((pressure(0.0) - pressure(10.0)) / 10.0, 1.225 * 9.80665, 0.01);
}

TEST_F(BarometerTest, AltitudeAndPressureOfTheSeaShiftTheReading) {
  const Instance high("barometer", world, {{"altitude", 1000.0}});
  EXPECT_NEAR(SensorRun(high).sense()[1], 999.84, 0.01) << "geometric 1000 m";
  const Instance low("barometer", world, {{"sea_level_pressure", 100000.0}});
  const Numbers seen = SensorRun(low).sense();
  EXPECT_EQ(seen[0], 100000.0);
  EXPECT_NEAR(seen[1], 110.9, 0.1) << "what an altimeter set to 1013.25 hPa shows";
}

TEST_F(BarometerTest, NoiseAndDriftHaveTheirDeviations) {
  const int count = 4000;
  const Instance noisy("barometer", world, {{"noise", 2.0}, {"period", 1}});
  EXPECT_NEAR(Spread(readings(noisy, 0, count)).deviation, 2.0, of_deviation(2.0, count));
  const Instance drifting("barometer", world, {{"drift", 30.0}, {"drift_time", 0.02}});
  Numbers starts, later, change;
  for (std::uint64_t env = 0; env < 2000; ++env) {
    SensorRun run(drifting, env);
    starts.push_back(run.group.output[0] - 101325.0);
    for (int n = 0; n < 20; ++n) run.step();
    later.push_back(run.group.output[0] - 101325.0);
    change.push_back(later.back() - std::exp(-1.0) * starts.back());
  }
  EXPECT_NEAR(Spread(starts).deviation, 30.0, of_deviation(30.0, 2000));
  EXPECT_NEAR(Spread(later).deviation, 30.0, of_deviation(30.0, 2000)) << "it is stationary";
  const double rest = 30.0 * std::sqrt(1.0 - std::exp(-2.0));
  EXPECT_NEAR(Spread(change).deviation, rest, of_deviation(rest, 2000)) << "after drift_time";
}

}  // namespace
}  // namespace skybody::testing
