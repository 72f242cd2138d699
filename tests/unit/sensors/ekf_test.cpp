// The filter's sources and bits. tests/unit/simulation/navigation_test.cpp flies by its estimates.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

using ::testing::HasSubstr;

class EkfTest : public ::testing::Test {
 protected:
  EkfTest() {
    world.add_quad("quad");
    world.add_sensor("imu", "specific_force", 3);
    world.add_sensor("imu", "angular_rate", 3);
    for (const char* name : {"pose", "gnss"}) world.add_sensor(name, "position", 3);
    world.add_sensor("pose", "rotation", 4);
    world.add_sensor("gnss", "velocity", 3);
    world.add_sensor("barometer", "altitude", 1);
    world.add_sensor("magnetometer", "field", 3);
    for (const char* name : {"pose", "gnss", "barometer", "magnetometer"}) {
      world.add_sensor(name, "stamp", 1);
    }
  }
  PluginWorld world;
};

TEST_F(EkfTest, GivesTheBitsOfDouble) {
  expect_same_bits("ekf", world, {{"pose", "pose"}});
  expect_same_bits("ekf", world,
                   {{"gnss", "gnss"},
                    {"barometer", "barometer"},
                    {"magnetometer", "magnetometer"},
                    {"field_noise", 0.5}});
  expect_same_bits("ekf", world,
                   {{"pose", "pose"},
                    {"gnss", "gnss"},
                    {"barometer", "barometer"},
                    {"magnetometer", "magnetometer"},
                    {"period", 2},
                    {"latency", 1}});
}

TEST_F(EkfTest, BeginsWithTheAttitudeOfForceAndField) {
  const Instance filter("ekf", world, {{"gnss", "gnss"}, {"magnetometer", "magnetometer"}});
  SensorRun run(filter);
  // Nose to the west, rolled by 0.3 rad: up and north in body axes.
  const double roll = 0.3, up_y = std::sin(roll), up_z = std::cos(roll);
  const Numbers force{0, 9.81 * up_y, 9.81 * up_z};
  const Numbers field{0, -20 * up_z - 44 * up_y, 20 * up_y - 44 * up_z};
  std::copy(force.begin(), force.end(), run.group.sensors.begin());
  std::copy(field.begin(), field.end(), run.group.sensors.begin() + 20);
  run.begin();
  const double half = 0.25 * 3.141592653589793;  // of the quarter turn about z, then of the roll
  const Numbers expected{
      std::cos(half) * std::cos(0.5 * roll), std::cos(half) * std::sin(0.5 * roll),
      std::sin(half) * std::sin(0.5 * roll), std::sin(half) * std::cos(0.5 * roll)};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(run.group.output[6 + k], expected[k], 1e-12) << k;
}

TEST_F(EkfTest, ASampleIsUsedOnce) {
  const Instance filter("ekf", world, {{"pose", "pose"}});
  SensorRun run(filter);
  const auto stamp = static_cast<std::size_t>(world.sensor_values - 4);
  const auto deviation = [&] { return run.group.output[13]; };
  run.group.sensors[2] = 9.81;
  run.group.sensors[12] = 1.0;  // w of the attitude
  run.begin();
  const double first = deviation();
  run.step();
  EXPECT_GE(deviation(), first) << "nothing new";
  run.group.sensors[stamp] = 0.002;
  run.step();
  EXPECT_LT(deviation(), 0.01 * first) << "a frame with 2 mm";
  const double second = deviation();
  run.step();
  EXPECT_GT(deviation(), second) << "the same frame again";
}

TEST_F(EkfTest, BadSourcesNameTheRemedy) {
  EXPECT_THAT(refusal("ekf", world, {}),
              HasSubstr("no source of position: name a sensor by `pose`"));
  EXPECT_THAT(refusal("ekf", world, {{"gnss", "gnss"}}),
              HasSubstr("`gnss` shows no heading: name a `magnetometer`, too"));
  EXPECT_THAT(refusal("ekf", world, {{"pose", "mocap"}}),
              HasSubstr("`pose` is `mocap`: no sensor output `mocap.position`"));
  EXPECT_THAT(
      refusal("ekf", world,
              {{"pose", "pose"}, {"magnetometer", "magnetometer"}, {"field", Numbers{0, 0, -44}}}),
      HasSubstr("`field` is vertical and shows no heading"));
}

}  // namespace
}  // namespace skybody::testing
