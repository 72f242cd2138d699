// A base on a rail: its pose over time, and parameters that are refused.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

class RailTest : public ::testing::Test {
 protected:
  RailTest() { world.add_quad("deck"); }
  /// The pose after `steps` physics steps of 1 ms.
  Numbers pose(const Instance& rail, Group& g, int steps) const {
    g.physics_step[0] = static_cast<std::uint64_t>(steps - 1);
    rail.call(Call::kControl, g);
    return g.output;
  }
  PluginWorld world;
  Parameters lift{{"times", Numbers{0, 2, 4}}, {"positions", Numbers{0, 0, 0, 0, 0, 1, 0, 0, 0}}};
};

TEST_F(RailTest, GoesFromStationToStationAtRest) {
  const Instance rail("rail", world, lift);
  Group g = rail.group(1);
  g.bodies[2] = 0.5;
  rail.call(Call::kReset, g);
  EXPECT_NEAR(pose(rail, g, 1000)[2], 1.0, 1e-12);  // half-way
  EXPECT_NEAR(pose(rail, g, 2000)[2], 1.5, 1e-12);
  EXPECT_NEAR(pose(rail, g, 2001)[2], 1.5, 1e-8);  // neither velocity nor acceleration there
  EXPECT_NEAR(pose(rail, g, 3000)[2], 1.0, 1e-12);
  EXPECT_NEAR(pose(rail, g, 9000)[2], 0.5, 1e-12);  // stays at the last one
}

TEST_F(RailTest, TurnsAndBeginsAgain) {
  lift.insert({"rpy", Numbers{0, 0, 0, 0, 0, 1, 0, 0, 0}});
  lift.insert({"repeat", true});
  const Instance rail("rail", world, lift);
  Group g = rail.group(1);
  rail.call(Call::kReset, g);
  const Numbers once = pose(rail, g, 1500), again = pose(rail, g, 5500);
  for (std::size_t k = 0; k < 7; ++k) EXPECT_NEAR(once[k], again[k], 1e-12);
  EXPECT_NEAR(pose(rail, g, 2000)[6], std::sin(0.5), 1e-12);
}

TEST_F(RailTest, GivesTheBitsOfDouble) { expect_same_bits("rail", world, lift); }

TEST_F(RailTest, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("rail", world, {{"times", Numbers{1, 2}}, {"positions", Numbers(6, 0.0)}}),
              HasSubstr("`times` has 2 values, the first 1 s"));
  EXPECT_THAT(refusal("rail", world, {{"times", Numbers{0, 2, 2}}, {"positions", Numbers(9, 0.0)}}),
              HasSubstr("`times[2]` is 2 s"));
  EXPECT_THAT(refusal("rail", world, {{"times", Numbers{0, 2}}, {"positions", Numbers(5, 0.0)}}),
              HasSubstr("`positions` has 5 values; allowed: 6"));
  EXPECT_THAT(
      refusal(
          "rail", world,
          {{"times", Numbers{0, 2}}, {"positions", Numbers{0, 0, 0, 0, 0, 1}}, {"repeat", true}}),
      HasSubstr("end where it begins"));
  EXPECT_THAT(
      refusal("rail", world, {{"times", Numbers{0, 2}}, {"positions", Numbers{0, 0, 1, 0, 0, 1}}}),
      HasSubstr("begin with 0, 0, 0"));
  world.robots[0].fixed_base = 1;
  EXPECT_THAT(refusal("rail", world, lift), HasSubstr("has a fixed base"));
}

}  // namespace
}  // namespace skybody::testing
