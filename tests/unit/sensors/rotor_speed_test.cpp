// Speeds of rotors: order, noise, resolution.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

using ::testing::HasSubstr;
constexpr const char* kLibrary = "rotor_speed_sensor";

class RotorSpeedTest : public ::testing::Test {
 protected:
  RotorSpeedTest() { world.add_quad("quad"); }
  PluginWorld world;
};

TEST_F(RotorSpeedTest, GivesTheBitsOfDouble) {
  expect_same_bits(kLibrary, world);
  expect_same_bits(kLibrary, world, {{"noise", 5.0}, {"resolution", 0.5}, {"latency", 2}});
}

TEST_F(RotorSpeedTest, ReadsTheRotorsOfItsRobotInOrder) {
  world.add_quad("other");
  const Instance sensor(kLibrary, world, {{"robot", "other"}});
  SensorRun run(sensor);
  run.group.rotor_speed = {1, 2, 3, 4, 500, 600, 700, 800};
  EXPECT_EQ(run.sense(), (Numbers{500, 600, 700, 800}));
}

TEST_F(RotorSpeedTest, NoiseAndResolutionAreAsGiven) {
  const int count = 4000;
  const Instance noisy(kLibrary, world, {{"noise", 3.0}});
  const Spread seen(readings(noisy, 3, count));
  EXPECT_NEAR(seen.mean, 0.0, of_mean(3.0, count));
  EXPECT_NEAR(seen.deviation, 3.0, of_deviation(3.0, count));
  const Instance coarse(kLibrary, world, {{"resolution", 10.0}});
  SensorRun run(coarse);
  run.group.rotor_speed = {4, 6, 994, 996};
  EXPECT_EQ(run.sense(), (Numbers{0, 10, 990, 1000}));
}

TEST_F(RotorSpeedTest, ARobotWithoutRotorsIsRefused) {
  world.add_robot("arm", 0, 0, 0);
  EXPECT_THAT(refusal(kLibrary, world, {{"robot", "arm"}}),
              HasSubstr("robot `arm` has no rotors, whose speeds sensor `rotor_speed` measures"));
}

}  // namespace
}  // namespace skybody::testing
