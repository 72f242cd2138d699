// The magnetometer: the field in turned axes, hard and soft iron, noise.
#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

constexpr double kQuarter = 0.5 * 3.141592653589793;

class MagnetometerTest : public ::testing::Test {
 protected:
  MagnetometerTest() { world.add_quad("quad"); }
  void expect_field(const Numbers& seen, const Numbers& field) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(seen[i], field[i], 1e-12);
  }
  PluginWorld world;
};

TEST_F(MagnetometerTest, GivesTheBitsOfDouble) {
  expect_same_bits("magnetometer", world);
  expect_same_bits("magnetometer", world,
                   {{"hard_iron", Numbers{1, 2, 3}},
                    {"soft_iron", Numbers{1, 0.1, 0, 0.1, 1.2, 0, 0, 0.3, 0.9}},
                    {"noise", 0.3},
                    {"resolution", 0.15},
                    {"range", 40.0},
                    {"period", 2},
                    {"dropout", 0.1}});
}

TEST_F(MagnetometerTest, TheFieldTurnsAgainstTheVehicle) {
  const Instance sensor("magnetometer", world);
  SensorRun run(sensor);
  expect_field(run.sense(), {20, 0, -44});
  run.yaw(kQuarter);  // nose to the west: north is on the right
  expect_field(run.sense(), {0, -20, -44});
  run.pitch(kQuarter);  // nose down
  expect_field(run.sense(), {44, 0, 20});
}

TEST_F(MagnetometerTest, IronBendsAndShiftsTheField) {
  const Instance sensor("magnetometer", world,
                        {{"field", Numbers{10, 20, 30}},
                         {"hard_iron", Numbers{1, 2, 3}},
                         {"soft_iron", Numbers{2, 0, 0, 0.5, 1, 0, 0, 0, 1}}});
  expect_field(SensorRun(sensor).sense(), {21, 27, 33});
}

TEST_F(MagnetometerTest, HardIronTurnsWithTheVehicle) {
  const Instance sensor("magnetometer", world, {{"hard_iron", Numbers{5, 0, 0}}});
  SensorRun run(sensor);
  run.yaw(kQuarter);
  expect_field(run.sense(), {5, -20, -44});
}

TEST_F(MagnetometerTest, NoiseResolutionAndRange) {
  const int count = 4000;
  const Instance noisy("magnetometer", world, {{"noise", 0.4}, {"period", 1}});
  const Spread seen(readings(noisy, 1, count));
  EXPECT_NEAR(seen.deviation, 0.4, of_deviation(0.4, count));
  const Instance coarse("magnetometer", world, {{"resolution", 3.0}, {"range", 30.0}});
  expect_field(SensorRun(coarse).sense(), {21, 0, -30});
}

}  // namespace
}  // namespace skybody::testing
