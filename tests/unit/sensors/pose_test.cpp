// Motion capture: the pose of a mounted marker, and its noise. timing_test.cpp tests its times.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

constexpr double kQuarter = 0.5 * 3.141592653589793;

class PoseTest : public ::testing::Test {
 protected:
  PoseTest() { world.add_quad("quad"); }
  PluginWorld world;
};

TEST_F(PoseTest, ReadsThePoseOfTheMountedFrame) {
  const Instance sensor("pose", world,
                        {{"position", Numbers{0.5, 0, 0.1}}, {"orientation", Numbers{0, 0, 1.0}}});
  SensorRun run(sensor);
  run.place(1, 2, 3);
  run.yaw(kQuarter);
  const Numbers& seen = run.sense();
  EXPECT_NEAR(seen[0], 1.0, 1e-12);
  EXPECT_NEAR(seen[1], 2.5, 1e-12);
  EXPECT_NEAR(seen[2], 3.1, 1e-12);
  EXPECT_NEAR(seen[3], std::cos(0.5 * (kQuarter + 1.0)), 1e-12);
  EXPECT_NEAR(seen[6], std::sin(0.5 * (kQuarter + 1.0)), 1e-12);
}

TEST_F(PoseTest, NoiseHasItsDeviations) {
  const int count = 4000;
  const Instance sensor("pose", world,
                        {{"position_noise", 0.002}, {"rotation_noise", 0.01}, {"period", 1}});
  EXPECT_NEAR(Spread(readings(sensor, 0, count)).deviation, 0.002, of_deviation(0.002, count));
  Numbers turns = readings(sensor, 5, count);
  for (double& y : turns) y *= 2.0;  // the vector part is half the angle
  EXPECT_NEAR(Spread(turns).deviation, 0.01, of_deviation(0.01, count));
  SensorRun run(sensor);
  for (int n = 0; n < 100; ++n) {
    run.step();
    double norm = 0.0;
    for (std::size_t k = 3; k < 7; ++k) norm += run.group.output[k] * run.group.output[k];
    EXPECT_NEAR(norm, 1.0, 1e-14) << "four roundings";
  }
}

TEST_F(PoseTest, ADrawnMountMovesTheFrame) {
  const Instance sensor("pose", world, {{"position", Numbers{0.5, 0, 0}}});
  SensorRun run(sensor);
  run.place(0, 0, 0);
  EXPECT_EQ(run.sense()[0], 0.5);
  run.group.params[static_cast<std::size_t>(sensor.env_param("position"))] = 0.25;
  EXPECT_EQ(run.sense()[0], 0.25);
}

}  // namespace
}  // namespace skybody::testing
