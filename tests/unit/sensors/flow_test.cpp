// Optical flow and height: translation, rotation, tilt, obstacles, limits.
#include <limits>

#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

using ::testing::HasSubstr;

class FlowTest : public ::testing::Test {
 protected:
  FlowTest() { world.add_quad("quad", 0, 0, 2); }
  void expect_reading(const Numbers& seen, double x, double y, double height) {
    EXPECT_NEAR(seen[0], x, 1e-12);
    EXPECT_NEAR(seen[1], y, 1e-12);
    EXPECT_NEAR(seen[2], height, 1e-12);
  }
  PluginWorld world;
};

TEST_F(FlowTest, GivesTheBitsOfDouble) {
  world.add_obstacle(SKYBODY_BOX, {0.4, 0.6, 0.8}, {0.1, 0.1, 0.2}, 0.3);
  expect_same_bits("flow", world);
  expect_same_bits("flow", world,
                   {{"flow_noise", 0.1},
                    {"height_noise", 0.02},
                    {"max_flow", 3.0},
                    {"position", Numbers{0.0, 0.1, -0.02}},
                    {"period", 2},
                    {"dropout", 0.2}});
}

TEST_F(FlowTest, IsSpeedOverHeightLessTheRates) {
  const Instance sensor("flow", world);
  SensorRun run(sensor);
  run.move(3, -1, 0.5);
  run.spin(0.2, 0.4, 9.0);
  expect_reading(run.sense(), 1.5 - 0.4, -0.5 + 0.2, 2.0);
}

TEST_F(FlowTest, IsThatOfTheCrazyfliesFilterWhenTilted) {
  // Measurement model of the firmware (kalman_core/mm_flow.c): v_x R22 / z - w_y, in body axes.
  const Instance sensor("flow", world);
  SensorRun run(sensor);
  const double angle = 0.3, speed = 2.0;
  run.pitch(angle);
  run.move(speed, 0, 0);
  run.spin(0, 0.7, 0);
  const double forward = speed * std::cos(angle), upright = std::cos(angle);
  expect_reading(run.sense(), forward * upright / 2.0 - 0.7, 0.0, 2.0 / upright);
}

TEST_F(FlowTest, ATurnAboutTheCameraIsSeenAsNoTranslation) {
  const Instance sensor("flow", world);
  SensorRun run(sensor);
  run.spin(0, 0, 5);
  expect_reading(run.sense(), 0, 0, 2.0);
}

TEST_F(FlowTest, AMountedCameraMovesWithTheTurn) {
  const Instance sensor("flow", world, {{"position", Numbers{0.5, 0, 0}}});
  SensorRun run(sensor);
  run.spin(0, 0, 4);
  expect_reading(run.sense(), 0, 0.5 * 4 / 2.0, 2.0);
}

TEST_F(FlowTest, SeesTheTopOfAnObstacle) {
  const int present = world.add_obstacle(SKYBODY_BOX, {1.0, 1.0, 0.5}, {0, 0, 0.25});
  const Instance sensor("flow", world);
  SensorRun run(sensor);
  run.move(3, 0, 0);
  expect_reading(run.sense(), 2.0, 0, 1.5);
  run.group.params[static_cast<std::size_t>(present)] = 0.0;
  expect_reading(run.sense(), 1.5, 0, 2.0);
}

TEST_F(FlowTest, BeyondItsReachOnlyTheHeightEnds) {
  const Instance sensor("flow", world, {{"max_height", 1.0}});
  SensorRun run(sensor);
  run.move(3, 0, 0);
  expect_reading(run.sense(), 1.5, 0, 1.0);
  run.pitch(3.0);  // looks at the sky
  run.spin(0, 0.25, 0);
  expect_reading(run.sense(), -0.25, 0, 1.0);
}

TEST_F(FlowTest, LimitsAndNoiseAreAsGiven) {
  const Instance limited("flow", world, {{"max_flow", 1.0}});
  SensorRun run(limited);
  run.move(-9, 0, 0);
  expect_reading(run.sense(), -1.0, 0, 2.0);
  const int count = 4000;
  const Instance noisy("flow", world,
                       {{"flow_noise", 0.05}, {"height_noise", 0.01}, {"period", 1}});
  EXPECT_NEAR(Spread(readings(noisy, 1, count)).deviation, 0.05, of_deviation(0.05, count));
  EXPECT_NEAR(Spread(readings(noisy, 2, count)).deviation, 0.01, of_deviation(0.01, count));
}

TEST_F(FlowTest, AHeightFieldIsRefused) {
  world.add_obstacle(SKYBODY_HEIGHT_FIELD, {10.0, 10.0, 2.0}, {0.0, 0.0, 0.0});
  EXPECT_THAT(refusal("flow", world, {}), HasSubstr("sensor `flow` knows boxes"));
}

}  // namespace
}  // namespace skybody::testing
