// The force and torque sensor: axes and origin of the joint, bias, range, noise.
// tests/unit/simulation/sensed_loads_test.cpp reads joints of the engine.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

using ::testing::HasSubstr;

class ForceTorqueTest : public ::testing::Test {
 protected:
  ForceTorqueTest() {
    world.add_quad("quad");
    world.add_arm_link("arm");
  }
  PluginWorld world;
};

TEST_F(ForceTorqueTest, GivesTheBitsOfDouble) {
  expect_same_bits("force_torque", world, {{"joint", "arm_joint"}});
  expect_same_bits("force_torque", world,
                   {{"joint", "arm_joint"},
                    {"force_noise", 0.1},
                    {"moment_noise", 0.1},
                    {"force_bias", Numbers{1, 2, 3}},
                    {"force_resolution", 0.2},
                    {"moment_range", 0.5},
                    {"period", 2},
                    {"latency", 1}});
}

TEST_F(ForceTorqueTest, ReadsTheLoadInTheAxesOfTheJoint) {
  SkybodyBodyInfo& arm = world.bodies[1];
  arm.joint_in_body[0] = 0.1;  // the joint is ahead of the arm's origin
  arm.joint_in_body[3] = arm.joint_in_body[6] = std::sqrt(0.5);  // its x axis is the arm's y
  const Instance sensor("force_torque", world, {{"joint", "arm_joint"}});
  EXPECT_EQ(sensor.declared.joint_reactions, (std::vector<int>{1}));
  SensorRun run(sensor);
  run.group.joint_reactions = {1, 2, 3, 0.5, 0, 0};
  // Moment less (0.1, 0, 0) x (1, 2, 3) = (0, -0.3, 0.2); then x of the arm is -y of the joint.
  const Numbers expected{2, -1, 3, 0.3, -0.5, -0.2};
  const Numbers& seen = run.sense();
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(seen[i], expected[i], 1e-14) << i;
}

TEST_F(ForceTorqueTest, BiasRangeAndResolution) {
  const Instance sensor("force_torque", world,
                        {{"joint", "arm_joint"},
                         {"force_bias", Numbers{0.3, 0, 0}},
                         {"force_resolution", 0.5},
                         {"moment_range", 2.0}});
  SensorRun run(sensor);
  run.group.joint_reactions = {1, 0, 0, 3, -3, 1};
  EXPECT_EQ(run.sense(), (Numbers{1.5, 0, 0, 2, -2, 1}));
}

TEST_F(ForceTorqueTest, AnUnknownJointIsRefused) {
  EXPECT_THAT(refusal("force_torque", world, {{"joint", "elbow"}}),
              HasSubstr("has no joint `elbow`: there are arm_joint"));
}

}  // namespace
}  // namespace skybody::testing
