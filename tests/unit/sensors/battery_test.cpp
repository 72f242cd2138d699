// The battery monitor: values of the effect, noise. tests/unit/simulation/sensed_loads_test.cpp
// reads the effect itself.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

constexpr const char* kLibrary = "battery_sensor";

class BatteryMonitorTest : public ::testing::Test {
 protected:
  BatteryMonitorTest() { world.add_quad("quad"); }
  PluginWorld world;
};

TEST_F(BatteryMonitorTest, GivesTheBitsOfDouble) {
  expect_same_bits(kLibrary, world);
  expect_same_bits(kLibrary, world, {{"voltage_noise", 0.1}, {"charge_noise", 0.2}, {"period", 3}});
}

TEST_F(BatteryMonitorTest, AsksForThePackOfItsRobot) {
  world.add_quad("other");
  const Instance sensor(kLibrary, world, {{"robot", "other"}});
  ASSERT_EQ(sensor.declared.sensor.requests.size(), 3u);
  EXPECT_EQ(sensor.declared.sensor.requests[0].name, "battery.voltage");
  EXPECT_EQ(sensor.declared.sensor.requests[0].robot, 1);
  SensorRun run(sensor);
  run.group.offered = {15.5, 22.0, 0.75};
  EXPECT_EQ(run.sense(), (Numbers{15.5, 22.0, 0.75}));
}

TEST_F(BatteryMonitorTest, NoiseHasItsDeviation) {
  const int count = 4000;
  const Instance sensor(kLibrary, world, {{"voltage_noise", 0.05}, {"current_noise", 0.4}});
  EXPECT_NEAR(Spread(readings(sensor, 0, count)).deviation, 0.05, of_deviation(0.05, count));
  EXPECT_NEAR(Spread(readings(sensor, 1, count)).deviation, 0.4, of_deviation(0.4, count));
  EXPECT_EQ(Spread(readings(sensor, 2, 10)).deviation, 0.0);
}

}  // namespace
}  // namespace skybody::testing
