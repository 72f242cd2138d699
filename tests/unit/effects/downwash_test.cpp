// Jets below rotors against their equations: affected bodies, region, force.
#include <cmath>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;
using ::testing::HasSubstr;

constexpr double kHub = 0.023;  // of QDrone2's hubs above its origin [m]

class DownwashTest : public ::testing::Test {
 protected:
  DownwashTest() {
    world.add_quad("upper");
    world.add_quad("lower");
  }

  static Parameters gym(Parameters more = {}) {
    more.insert({{"radius", 0.1}, {"by_thrust", false}, {"robots", Words{"upper"}}});
    return more;
  }
  static Parameters gzdrl(Parameters more = {}) {
    more.insert({{"form", "gzdrl"}, {"force", 3.0}, {"spread", 0.2}, {"start", 0.05}});
    more.insert({{"by_thrust", false}, {"robots", Words{"upper"}}});
    return more;
  }
  static void place(Group& g, int body, const Vec3<double>& p,
                    const Quat<double>& turn = Quat<double>::identity()) {
    const double values[] = {p.x, p.y, p.z, turn.w, turn.x, turn.y, turn.z};
    std::copy(std::begin(values), std::end(values), g.bodies.begin() + 13 * body);
  }
  static Vec3<double> force(const Group& g, int body) {
    const double* f = g.held[SKYBODY_HELD_WRENCH].data() + 6 * body;
    for (int k = 3; k < 6; ++k) EXPECT_EQ(f[k], 0.0);
    return {f[0], f[1], f[2]};
  }
  /// Force on body 1 at this distance below the hubs of body 0 and beside them.
  static Vec3<double> push(const Instance& effect, double below, double beside) {
    Group g = effect.group(1);
    place(g, 0, {0.3, -0.2, 5.0 - kHub});
    place(g, 1, {0.3, -0.2 + beside, 5.0 - below});
    effect.call(Call::kApply, g);
    EXPECT_EQ(norm(force(g, 0)), 0.0);
    return force(g, 1);
  }
  /// Rotor speed at which QDrone2's four rotors carry its weight [rad/s].
  static double hover() { return std::sqrt(1.54 * 9.81 / (4.0 * 1.9533e-6)); }
  PluginWorld world;
};

TEST_F(DownwashTest, GivesTheBitsOfDouble) {
  expect_same_bits("downwash", world, {{"radius", 0.1}, {"k3", 0.2}});
  expect_same_bits("downwash", world, gzdrl({{"by_thrust", true}}));
}

TEST_F(DownwashTest, HasTheFormOfGymPybulletDrones) {
  const Instance effect("downwash", world, gym());
  for (const double below : {0.8, 1.0, 2.5}) {
    for (const double beside : {0.0, 0.02, 0.1}) {
      const double quarter = 0.1 / (4.0 * below), width = 0.16 * below - 0.11;
      const double w =
          2267.18 * quarter * quarter * std::exp(-0.5 * beside * beside / (width * width));
      // The distances are rounded, and the force changes by some newtons per centimetre.
      EXPECT_NEAR(push(effect, below, beside).z, -w, 1e-11) << below << ", " << beside;
    }
  }
}

TEST_F(DownwashTest, OfThatFormGrowsNoMoreNearerThanTheLeastDistance) {
  const Instance effect("downwash", world, gym({{"least_distance", 1.0}, {"k3", 1.0}}));
  EXPECT_NEAR(push(effect, 0.3, 0.0).z, push(effect, 1.0, 0.0).z, 1e-11);
}

TEST_F(DownwashTest, HasTheFormOfTheReference) {
  const Instance effect("downwash", world, gzdrl());
  for (const double below : {0.1, 1.0, 2.5}) {
    for (const double beside : {0.0, 0.2, 0.5}) {
      const double ratio = beside * beside / (0.2 * below + 0.05);
      EXPECT_NEAR(push(effect, below, beside).z, -3.0 * std::exp(-0.5 * ratio * ratio), 1e-13);
    }
  }
}

TEST_F(DownwashTest, IsNothingAboveOrBeyondTheReachOrFarBeside) {
  const Instance effect("downwash", world, gzdrl({{"reach", 3.0}}));
  EXPECT_EQ(push(effect, -0.1, 0.0).z, 0.0);
  EXPECT_EQ(push(effect, 3.1, 0.0).z, 0.0);
  EXPECT_EQ(push(effect, 1.0, 20.0).z, 0.0);
  EXPECT_NE(push(effect, 2.9, 0.0).z, 0.0);
}

TEST_F(DownwashTest, BlowsAlongTheAxisOfATiltedRobot) {
  const Instance effect("downwash", world, gzdrl());
  const Quat<double> turn = from_rpy(0.5, -0.3, 0.8);
  const Vec3<double> axis = rotate(turn, Vec3<double>{0.0, 0.0, 1.0});
  Group g = effect.group(1);
  place(g, 0, {0.0, 0.0, 5.0}, turn);
  place(g, 1, axis * (kHub - 2.0) + Vec3<double>{0.0, 0.0, 5.0});
  effect.call(Call::kApply, g);
  EXPECT_LT(norm(force(g, 1) + axis * 3.0), 1e-13);
}

TEST_F(DownwashTest, GrowsWithTheThrustOverTheWeight) {
  const Instance effect("downwash", world, gzdrl({{"by_thrust", true}}));
  Group g = effect.group(1);
  place(g, 0, {0.0, 0.0, 5.0});
  place(g, 1, {0.0, 0.0, 4.0});
  for (std::size_t i = 0; i < 4; ++i) g.rotor_speed[i] = hover() * (i < 2 ? 1.0 : 2.0);
  effect.call(Call::kApply, g);
  EXPECT_NEAR(force(g, 1).z, -3.0 * 2.5, 1e-13);
  Group still = effect.group(1);
  place(still, 0, {0.0, 0.0, 5.0});
  place(still, 1, {0.0, 0.0, 4.0});
  effect.call(Call::kApply, still);
  EXPECT_EQ(force(still, 1).z, 0.0);
}

TEST_F(DownwashTest, OfSeveralRobotsAddsUp) {
  world.add_quad("top");
  const Instance effect("downwash", world, gzdrl({{"robots", Words{"upper", "top"}}}));
  Group g = effect.group(1);
  place(g, 2, {0.0, 0.0, 7.0});
  place(g, 0, {0.0, 0.0, 6.0});
  place(g, 1, {0.0, 0.0, 5.0});
  effect.call(Call::kApply, g);
  EXPECT_NEAR(force(g, 1).z, -6.0, 1e-14);
  EXPECT_NEAR(force(g, 0).z, -3.0, 1e-14);
  EXPECT_EQ(force(g, 2).z, 0.0);
}

TEST_F(DownwashTest, PushesAPayloadOfItsOwnRobotWhereThatIsNamed) {
  PluginWorld one;
  one.add_quad("quad");
  one.add_payload("bob");
  const Instance effect("downwash", one,
                        gzdrl({{"robots", Words{"quad"}}, {"own_links", Words{"quad.bob"}}}));
  Group g = effect.group(1);
  place(g, 0, {0.0, 0.0, 5.0});
  place(g, 1, {0.0, 0.0, 4.0});
  effect.call(Call::kApply, g);
  EXPECT_NEAR(force(g, 1).z, -3.0, 1e-14);
  EXPECT_EQ(force(g, 0).z, 0.0);
}

TEST_F(DownwashTest, HasTheDerivativesOfDifferences) {
  expect_derivatives({"downwash",
                      world,
                      {{"form", "gzdrl"}, {"force", 3.0}, {"spread", 1.0}, {"start", 1.0}},
                      Call::kApply,
                      {}},
                     {"bodies", "params", "rotor_speed"});
  expect_derivatives({"downwash", world, {{"radius", 0.1}, {"k3", 1.0}}, Call::kApply, {}},
                     {"bodies", "params", "rotor_speed"});
}

TEST_F(DownwashTest, SaysWhatDoesNotFit) {
  EXPECT_EQ(
      refusal("downwash", world, {}),
      "`radius` is 0, but `form: gym_pybullet_drones` needs it: allowed are values above 0 m");
  EXPECT_EQ(refusal("downwash", world, {{"form", "gzdrl"}}),
            "`force` is 0, but `form: gzdrl` needs it: allowed are values above 0 N");
  EXPECT_EQ(refusal("downwash", world, {{"form", "gzdrl"}, {"force", 1.0}}),
            "`spread` and `start` are both 0, so the jet has no width: raise one of them");
  EXPECT_EQ(refusal("downwash", world, gzdrl({{"own_links", Words{"bob"}}})),
            "`own_links` has `bob`: allowed are names as ROBOT.LINK, such as quad.payload");
  EXPECT_EQ(refusal("downwash", world, gzdrl({{"own_links", Words{"upper.bob"}}})),
            "robot `upper` has no link `bob`: there are base");
  world.gravity = 0.0;
  EXPECT_EQ(refusal("downwash", world, gzdrl({{"by_thrust", true}})),
            "`by_thrust` compares with the thrust in hover, which is 0 without gravity: set it to "
            "false");
}

TEST_F(DownwashTest, RefusesWorldsInWhichItWouldPushNothing) {
  PluginWorld one;
  one.add_quad("quad");
  EXPECT_EQ(refusal("downwash", one, {{"radius", 0.1}}),
            "there is nothing that downwash could push: add a robot, name links in `own_links`, or "
            "leave the effect out");
}

TEST_F(DownwashTest, RefusesRotorsThatPushAgainstOneAnother) {
  for (std::size_t i = 0; i < 4; ++i) world.rotors[i].axis[2] = i < 2 ? 1.0 : -1.0;
  EXPECT_THAT(refusal("downwash", world, gzdrl()),
              HasSubstr("the rotors of robot `upper` push against one another"));
}

}  // namespace
}  // namespace skybody::testing
