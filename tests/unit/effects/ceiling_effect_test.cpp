// Gains of thrust below a ceiling against their equations.
#include <cmath>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;
using ::testing::HasSubstr;

constexpr double kHub = 0.023;  // of QDrone2's hubs above its origin [m]

class CeilingEffectTest : public ::testing::Test {
 protected:
  CeilingEffectTest() { world.add_quad("quad"); }

  static Parameters below_three_metres(Parameters more = {}) {
    more.insert({{"height", 3.0}, {"radius", 0.1}});
    return more;
  }
  /// Gain on the thrust of the first rotor, with its hub at this distance below the ceiling.
  static double gain(const Instance& effect, double distance, double roll = 0.0) {
    Group g = effect.group(1);
    const Quat<double> turn = from_rpy(roll, 0.0, 0.0);
    g.bodies[2] = 3.0 - distance - kHub * std::cos(roll) - 0.127 * std::sin(roll);
    g.bodies[3] = turn.w;
    g.bodies[4] = turn.x;
    effect.call(Call::kApply, g);
    EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_GAIN][SKYBODY_GAIN_MOMENT], 1.0);
    return g.held[SKYBODY_HELD_ROTOR_GAIN][SKYBODY_GAIN_THRUST];
  }
  /// By momentum theory at constant power: (wake speed over twice the speed at the disk)^(2/3).
  static double by_momentum(double ratio) {
    return std::cbrt(std::pow(0.5 + 0.5 * std::sqrt(1.0 + 0.125 * ratio * ratio), 2));
  }
  PluginWorld world;
};

TEST_F(CeilingEffectTest, GivesTheBitsOfDouble) {
  expect_same_bits("ceiling_effect", world, {{"height", 0.5}, {"radius", 0.3}});
  expect_same_bits(
      "ceiling_effect", world,
      {{"height", 0.5}, {"radius", 0.1}, {"form", "fitted"}, {"a1", 6.9}, {"a2", 0.038}});
}

TEST_F(CeilingEffectTest, IsMomentumTheorysAtConstantPower) {
  const Instance effect("ceiling_effect", world, below_three_metres());
  for (const double distance : {0.03, 0.1, 0.5, 2.0}) {
    // exp and log are within an ulp or two, and the distance is rounded.
    EXPECT_NEAR(gain(effect, distance), by_momentum(0.1 / distance), 1e-13) << distance;
  }
}

TEST_F(CeilingEffectTest, GrowsNoMoreNearerThanTheLeastDistance) {
  const Instance effect("ceiling_effect", world,
                        below_three_metres({{"least_distance_ratio", 0.4}}));
  EXPECT_NEAR(gain(effect, 0.01), by_momentum(1.0 / 0.4), 1e-14);
}

TEST_F(CeilingEffectTest, CountsTheWayUpTheAxisOfATiltedRotor) {
  const Instance effect("ceiling_effect", world, below_three_metres());
  EXPECT_NEAR(gain(effect, 0.2, 0.7), by_momentum(0.1 * std::cos(0.7) / 0.2), 1e-13);
  EXPECT_EQ(gain(effect, 0.2, 2.5), 1.0);  // it draws its air from below
}

TEST_F(CeilingEffectTest, IsNothingAboveTheCeiling) {
  const Instance effect("ceiling_effect", world, below_three_metres());
  EXPECT_EQ(gain(effect, -0.05), 1.0);
}

TEST_F(CeilingEffectTest, IsAFitWhereTheUserGivesOne) {
  const Instance effect(
      "ceiling_effect", world,
      below_three_metres(
          {{"form", "fitted"}, {"a1", 6.9}, {"a2", 0.05}, {"least_distance_ratio", 0.01}}));
  for (const double distance : {0.02, 0.1, 1.0}) {
    const double ratio = 0.1 / (distance + 0.05);
    EXPECT_NEAR(gain(effect, distance), 1.0 / (1.0 - ratio * ratio / 6.9), 1e-13) << distance;
  }
}

TEST_F(CeilingEffectTest, AFitThatIsDrawnTooSteepGivesFourTimesTheThrust) {
  const Instance effect("ceiling_effect", world,
                        below_three_metres({{"form", "fitted"}, {"a1", 50.0}}));
  Group g = effect.group(1);
  g.params[static_cast<std::size_t>(effect.env_param("a1"))] = 0.0;
  g.bodies[2] = 2.95;
  effect.call(Call::kApply, g);
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_GAIN][0], 4.0);
}

TEST_F(CeilingEffectTest, HasTheDerivativesOfDifferences) {
  expect_derivatives(
      {"ceiling_effect", world, {{"height", 0.5}, {"radius", 0.3}}, Call::kApply, {}},
      {"bodies", "params"});
}

TEST_F(CeilingEffectTest, SaysWhatDoesNotFit) {
  EXPECT_EQ(refusal("ceiling_effect", world, {{"height", -3.0}, {"radius", 0.1}}),
            "`height` is -3 m, below the ground z = 0 and all robots (the lowest begins at 1 m): "
            "raise it");
  EXPECT_EQ(refusal("ceiling_effect", world, below_three_metres({{"form", "fitted"}})),
            "`a1` is 0, but `form: fitted` needs it: allowed are values above 0; take those of a "
            "fit to measurements with these rotors");
  EXPECT_EQ(
      refusal("ceiling_effect", world, below_three_metres({{"form", "fitted"}, {"a1", 30.0}})),
      "with `a1` 30 and `a2` 0 m the thrust grows by 6 at the least distance: allowed are "
      "factors up to 4; raise `a1`, `a2` or `least_distance_ratio`");
  EXPECT_THAT(
      refusal("ceiling_effect", world, below_three_metres({{"form", "fitted"}, {"a1", 1.0}})),
      HasSubstr("the thrust grows by more than any factor at the least distance"));
  EXPECT_THAT(refusal("ceiling_effect", world, below_three_metres({{"robots", Words{"quda"}}})),
              HasSubstr("no robot `quda`"));
}

}  // namespace
}  // namespace skybody::testing
