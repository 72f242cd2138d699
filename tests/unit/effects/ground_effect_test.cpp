// Thrust gains near the ground against their equations: height, tilt, bounds, the reference's form.
#include <cmath>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;
using ::testing::HasSubstr;

constexpr double kHub = 0.023;  // of QDrone2's hubs above its origin [m]

class GroundEffectTest : public ::testing::Test {
 protected:
  GroundEffectTest() { world.add_quad("quad"); }

  /// Gains on the thrust of the four rotors of the first robot at this pose.
  static Numbers gains(const Instance& effect, double z, const Quat<double>& turn) {
    Group g = effect.group(1);
    g.bodies[2] = z;
    g.bodies[3] = turn.w;
    g.bodies[4] = turn.x;
    g.bodies[5] = turn.y;
    g.bodies[6] = turn.z;
    effect.call(Call::kApply, g);
    Numbers out;
    for (std::size_t i = 0; i < 4; ++i) {
      const double* gain = g.held[SKYBODY_HELD_ROTOR_GAIN].data() + 4 * i;
      out.push_back(gain[SKYBODY_GAIN_THRUST]);
      EXPECT_EQ(gain[SKYBODY_GAIN_MOMENT], 1.0);
      EXPECT_EQ(gain[SKYBODY_GAIN_DRAG], 1.0);
      EXPECT_EQ(gain[SKYBODY_GAIN_ROLLING], 1.0);
    }
    return out;
  }
  static Quat<double> level() { return Quat<double>::identity(); }
  PluginWorld world;
};

TEST_F(GroundEffectTest, GivesTheBitsOfDouble) {
  expect_same_bits("ground_effect", world, {{"radius", 0.3}});
  expect_same_bits("ground_effect", world, {{"form", "gzdrl"}, {"ground_constant", 1.17e-9}});
}

TEST_F(GroundEffectTest, IsCheesemanAndBennettsOfALevelRotor) {
  const Instance effect("ground_effect", world, {{"radius", 0.1}});
  for (const double height : {0.06, 0.1, 0.3, 2.0}) {
    const double share = 0.1 / (4.0 * height);
    for (const double gain : gains(effect, height - kHub, level())) {
      EXPECT_NEAR(gain, 1.0 / (1.0 - share * share), 1e-14);  // roundings of the height
    }
  }
}

TEST_F(GroundEffectTest, GrowsNoMoreBelowTheLeastHeight) {
  const Instance effect("ground_effect", world, {{"radius", 0.1}, {"least_height_ratio", 0.5}});
  const double most = 1.0 / (1.0 - 0.25);
  for (const double height : {0.05, 0.01, 0.0, -1.0}) {
    EXPECT_NEAR(gains(effect, height - kHub, level())[0], most, 1e-14) << height;
  }
}

TEST_F(GroundEffectTest, CountsTheWayDownTheAxisOfATiltedRotor) {
  const Instance effect("ground_effect", world, {{"radius", 0.1}});
  const double roll = 0.6;
  const Numbers got = gains(effect, 0.4, from_rpy(roll, 0.0, 0.3));
  const double sides[] = {0.127, -0.127, -0.127, 0.127};  // y of the hubs
  for (std::size_t i = 0; i < 4; ++i) {
    const double height = 0.4 + sides[i] * std::sin(roll) + kHub * std::cos(roll);
    const double share = 0.1 * std::cos(roll) / (4.0 * height);
    EXPECT_NEAR(got[i], 1.0 / (1.0 - share * share), 1e-14);
  }
}

TEST_F(GroundEffectTest, IsNothingForARotorThatBlowsUp) {
  const Instance effect("ground_effect", world, {{"radius", 0.1}});
  EXPECT_EQ(gains(effect, 0.2, from_rpy(3.0, 0.0, 0.0)), Numbers(4, 1.0));
}

TEST_F(GroundEffectTest, IsNothingWithARadiusThatIsDrawnAsZero) {
  const Instance effect("ground_effect", world, {{"radius", 0.1}});
  Group g = effect.group(1);
  g.params[static_cast<std::size_t>(effect.env_param("radius"))] = 0.0;
  g.bodies[2] = -1.0;
  effect.call(Call::kApply, g);
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_GAIN][SKYBODY_GAIN_THRUST], 1.0);
}

TEST_F(GroundEffectTest, OfTheReferenceAddsAThrustOverTheSquaredHeight) {
  const double k = 1.17198e-9, thrust_constant = 1.9533e-6;
  const Instance effect("ground_effect", world, {{"form", "gzdrl"}, {"ground_constant", k}});
  for (const double height : {0.5, 0.06, 0.05, 0.01, -0.3}) {
    const double h = std::max(0.05, std::abs(height));
    // Roundings of the height, times the slope of the gain.
    EXPECT_NEAR(gains(effect, height - kHub, level())[2], 1.0 + k / thrust_constant / (h * h),
                1e-14);
  }
  // At any attitude.
  EXPECT_NEAR(gains(effect, 0.3 + kHub, from_rpy(kPi, 0.0, 0.0))[0],
              1.0 + k / thrust_constant / 0.09, 1e-14);
}

TEST_F(GroundEffectTest, OfTheReferenceFollowsADrawnThrustConstant) {
  const Instance effect("ground_effect", world, {{"form", "gzdrl"}, {"ground_constant", 1e-9}});
  Group g = effect.group(1);
  g.bodies[2] = 0.5 - kHub;
  g.params[static_cast<std::size_t>(world.rotors[0].first_param)] = 4e-6;
  effect.call(Call::kApply, g);
  EXPECT_NEAR(g.held[SKYBODY_HELD_ROTOR_GAIN][0], 1.0 + 1e-9 / 4e-6 / 0.25, 1e-14);
}

TEST_F(GroundEffectTest, ServesTheRobotsThatItNames) {
  world.add_quad("other", 0.0, 0.0, 0.2);
  const Instance effect("ground_effect", world, {{"radius", 0.1}, {"robots", Words{"other"}}});
  Group g = effect.group(1);
  g.bodies[2] = 0.1;
  effect.call(Call::kApply, g);
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_GAIN][0], 1.0);
  EXPECT_GT(g.held[SKYBODY_HELD_ROTOR_GAIN][16], 1.01);
}

TEST_F(GroundEffectTest, HasTheDerivativesOfDifferences) {
  expect_derivatives({"ground_effect", world, {{"radius", 0.3}}, Call::kApply, {}},
                     {"bodies", "params"});
  expect_derivatives(
      {"ground_effect", world, {{"form", "gzdrl"}, {"ground_constant", 1e-7}}, Call::kApply, {}},
      {"bodies", "params"});
}

TEST_F(GroundEffectTest, SaysWhatDoesNotFit) {
  EXPECT_EQ(refusal("ground_effect", world, {}),
            "`radius` is 0, but `form: cheeseman_bennett` needs it: allowed are values above 0; "
            "give the rotors' radius [m]");
  EXPECT_EQ(refusal("ground_effect", world, {{"form", "gzdrl"}, {"radius", 0.1}}),
            "`ground_constant` is 0, but `form: gzdrl` needs it: allowed are values above 0, such "
            "as the thrust constant times the rotor's squared radius over 16");
  EXPECT_THAT(refusal("ground_effect", world, {{"radius", 0.1}, {"robots", Words{"quda"}}}),
              HasSubstr("no robot `quda`"));
  PluginWorld bare;
  bare.add_robot("crate", 0, 0, 0);
  EXPECT_THAT(refusal("ground_effect", bare, {{"radius", 0.1}}),
              HasSubstr("no robot has rotors, which the ground effect acts on"));
}

}  // namespace
}  // namespace skybody::testing
