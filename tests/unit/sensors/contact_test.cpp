// The contact sensor: axes, point of reference, partners, threshold, noise.
// tests/unit/simulation/sensed_loads_test.cpp reads contacts of the engine.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

using ::testing::HasSubstr;
constexpr double kQuarter = 0.5 * 3.141592653589793;

class ContactSensorTest : public ::testing::Test {
 protected:
  ContactSensorTest() { world.add_quad("quad"); }
  PluginWorld world;
};

TEST_F(ContactSensorTest, GivesTheBitsOfDouble) {
  expect_same_bits("contact", world);
  expect_same_bits("contact", world,
                   {{"partner", "ground"},
                    {"force_noise", 0.1},
                    {"moment_noise", 0.1},
                    {"threshold", 0.5},
                    {"position", Numbers{0.1, 0, 0}},
                    {"latency", 2}});
}

TEST_F(ContactSensorTest, ForceAndMomentAreInSensorAxesAboutTheSensor) {
  const Instance sensor("contact", world, {{"position", Numbers{0.2, 0, 0}}});
  SensorRun run(sensor);
  run.yaw(kQuarter);  // x of the body is y of W
  run.group.contacts = {0, 10, 5, 1, 0, 0, 1};
  const Numbers& seen = run.sense();
  // Arm (0, 0.2, 0) in W: moment (1, 0, 0) - arm x force = (1 - 1, 0, 0); x of W is -y of the body.
  const Numbers expected{10, 0, 5, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(seen[i], expected[i], 1e-14) << i;
}

TEST_F(ContactSensorTest, ALightTouchIsBelowTheThreshold) {
  const Instance sensor("contact", world, {{"threshold", 2.0}});
  SensorRun run(sensor);
  run.group.contacts = {0, 0, 1.5, 0, 0, 0, 1};
  EXPECT_EQ(run.sense()[6], 0.0);
  run.group.contacts[2] = 2.5;
  EXPECT_EQ(run.sense()[6], 1.0);
}

TEST_F(ContactSensorTest, PartnersAreNamed) {
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {8, 0, 1}, 0.0, "ball");
  world.add_quad("other");
  const auto pair = [&](const char* partner) {
    const Instance sensor("contact", world, {{"robot", "quad"}, {"partner", partner}});
    EXPECT_FALSE(sensor.declared.needs_contacts);
    return sensor.declared.contact_pairs.at(0);
  };
  EXPECT_EQ(pair("ground").partner, SKYBODY_GROUND);
  EXPECT_EQ(pair("ball").partner, SKYBODY_OBSTACLE);
  EXPECT_EQ(pair("ball").other, 0);
  EXPECT_EQ(pair("other.base").partner, SKYBODY_OTHER_BODY);
  EXPECT_EQ(pair("other.base").other, 1);
}

TEST_F(ContactSensorTest, AnUnknownPartnerIsRefused) {
  EXPECT_THAT(refusal("contact", world, {{"partner", "wall"}}),
              HasSubstr("`partner` is `wall`, which is no obstacle; allowed: any, ground"));
  EXPECT_THAT(refusal("contact", world, {{"partner", "quad.base"}}),
              HasSubstr("belongs to the body of the sensor itself"));
  EXPECT_THAT(refusal("contact", world, {{"partner", "quad.tail"}}), HasSubstr("no link `tail`"));
}

}  // namespace
}  // namespace skybody::testing
