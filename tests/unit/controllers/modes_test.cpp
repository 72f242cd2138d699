// Control modes by hand calculation, and the same bits at every instruction set.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

constexpr double kThrustConstant = 1.9533e-6;
constexpr double kFull = kThrustConstant * 2246.0 * 2246.0;

class Modes : public ::testing::Test {
 protected:
  Modes() { world.add_quad("quad"); }
  std::vector<double> control(const Instance& instance, Group& g,
                              const std::vector<double>& input) {
    g.input = input;
    instance.call(Call::kControl, g);
    return g.output;
  }
  PluginWorld world;
};

TEST_F(Modes, AllGiveTheBitsOfDouble) {
  for (const char* name : {"rotor_speed", "throttle", "srt", "ctbt", "ctbr", "wrench", "velocity",
                           "attitude", "position"}) {
    expect_same_bits(name, world);
  }
  expect_same_bits("ctbt", world, {{"apply", "body"}});
  expect_same_bits("ctbr", world, {{"apply", "body"}});
  expect_same_bits("ctbr", world, {{"apply", "body"}, {"pd", false}});
  expect_same_bits("velocity", world, {{"form", "position"}});
}

TEST_F(Modes, RotorSpeedIsClampedToTheRotor) {
  const Instance instance("rotor_speed", world, {{"max_speed", 2300}});
  EXPECT_EQ(instance.declared.controller.low, std::vector<double>(4, 0.0));
  EXPECT_EQ(instance.declared.controller.high, std::vector<double>(4, 2300.0));
  Group g = instance.group(1);
  EXPECT_EQ(control(instance, g, {-5.0, 1150.0, 2246.0, 2300.0}),
            (std::vector<double>{0.0, 1150.0, 2246.0, 2246.0}));
}

TEST_F(Modes, AThrottleIsAShareOfTheEnvironmentsOwnLargestSpeed) {
  const Instance instance("throttle", world, {{"min_throttle", 0.25}});
  EXPECT_EQ(instance.declared.controller.low, std::vector<double>(4, 0.25));
  EXPECT_EQ(instance.declared.controller.high, std::vector<double>(4, 1.0));
  Group g = instance.group(1);
  g.params[static_cast<std::size_t>(world.rotors[2].first_param + SKYBODY_ROTOR_MAX_SPEED)] = 400.0;
  EXPECT_EQ(control(instance, g, {-0.5, 0.5, 0.25, 1.5}),
            (std::vector<double>{0.0, 1123.0, 100.0, 2246.0}));
}

TEST_F(Modes, SrtGivesTheThrustBack) {
  const Instance instance("srt", world);
  EXPECT_NEAR(instance.declared.controller.high[0], kFull, 1e-12);
  Group g = instance.group(1);
  const std::vector<double> wanted = {0.0, 1.25, 9.0, 3.777};
  const std::vector<double> speed = control(instance, g, wanted);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(kThrustConstant * speed[i] * speed[i], wanted[i], 1e-14 * kFull);
  }
  EXPECT_EQ(control(instance, g, {-1.0, 0.0, 0.0, 0.0})[0], 0.0);
  EXPECT_NEAR(control(instance, g, {100.0, 0.0, 0.0, 0.0})[0], 2246.0, 1e-9);
}

TEST_F(Modes, VelocityHoldsItsLimitsAndThePositionFormIsLevel) {
  const Instance velocity("velocity", world, {{"max_velocity", std::vector<double>{1, 2, 3}}});
  Group g = velocity.group(1);
  EXPECT_EQ(control(velocity, g, {5, -5, 5, -1, 0.5, 9}),
            (std::vector<double>{1, -2, 3, -1, 0.5, 3}));
  const Instance position("velocity", world, {{"form", "position"}});
  EXPECT_EQ(position.declared.controller.outputs[0].signal, SKYBODY_POSE);
  Group h = position.group(1);
  const std::vector<double> pose = control(position, h, {9.0, 1.0, 1.0, 3.0});
  EXPECT_EQ(pose[0], 5.0);
  EXPECT_NEAR(pose[3], std::cos(1.5), 1e-15);
  EXPECT_NEAR(pose[6], std::sin(1.5), 1e-15);
  EXPECT_EQ(pose[4], 0.0);
}

TEST_F(Modes, WrenchActsAtTheNamedLinksInWorldAxes) {
  const int bob = world.add_payload("bob");
  const Instance instance("wrench", world, {{"links", std::vector<std::string>{"base", "bob"}}});
  ASSERT_EQ(instance.declared.controller.sites.size(), 2u);
  EXPECT_EQ(instance.declared.controller.sites[1].body, bob);
  EXPECT_TRUE(instance.declared.controller.sites[1].world_axes);
  EXPECT_NEAR(instance.declared.controller.high[2], 2.0 * (1.54 + 0.205) * 9.81, 1e-12);
  Group g = instance.group(1);
  std::vector<double> input(12, 0.1);
  input[8] = -1000.0;
  const std::vector<double> out = control(instance, g, input);
  EXPECT_EQ(out[0], 0.1);
  EXPECT_EQ(out[8], -instance.declared.controller.high[8]);
}

TEST_F(Modes, AttitudeTurnsTheShortWay) {
  const Instance instance("attitude", world);
  Group g = instance.group(1);
  const double half = 0.05;
  for (const double sign : {1.0, -1.0}) {
    const std::vector<double> out =
        control(instance, g, {10.0, sign * std::cos(half), sign * std::sin(half), 0.0, 0.0});
    EXPECT_EQ(out[0], 10.0);
    EXPECT_NEAR(out[1], 8.0 * 2.0 * std::sin(half), 1e-14);
    EXPECT_NEAR(out[3], 0.0, 1e-15);
  }
  EXPECT_EQ(control(instance, g, {10.0, 0.0, 0.0, 0.0, 0.0}), (std::vector<double>{10, 0, 0, 0}));
}

TEST_F(Modes, PositionCarriesTheWeightAtTheGoal) {
  const Instance instance("position", world);
  Group g = instance.group(1);
  const std::vector<double> out = control(instance, g, {0.0, 0.0, 1.0, 0.4});
  EXPECT_NEAR(out[0], 1.54 * 9.81, 1e-12);
  EXPECT_NEAR(out[1], std::cos(0.2), 1e-15);
  EXPECT_NEAR(out[4], std::sin(0.2), 1e-15);
}

TEST_F(Modes, PositionTiltsTowardsTheGoal) {
  const Instance instance("position", world);
  Group g = instance.group(1);
  const std::vector<double> out = control(instance, g, {0.5, 0.0, 1.0, 0.0});
  const double tilt = std::atan2(2.0, 9.81);
  EXPECT_NEAR(out[3], std::sin(0.5 * tilt), 1e-14);  // about +y: towards +x
  EXPECT_NEAR(out[2], 0.0, 1e-15);
}

TEST_F(Modes, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("rotor_speed", world, {{"min_speed", 2400}}),
              HasSubstr("`min_speed` 2400 is not below"));
  EXPECT_THAT(refusal("throttle", world, {{"min_throttle", 0.5}, {"max_throttle", 0.5}}),
              HasSubstr("`min_throttle` 0.5 is not below `max_throttle` 0.5"));
  EXPECT_THAT(refusal("srt", world, {{"min_thrust", 3}, {"max_thrust", 2}}),
              HasSubstr("`min_thrust` 3 is not below `max_thrust` 2: lower the first"));
  EXPECT_THAT(refusal("ctbt", world, {{"max_thrust", 50}}),
              HasSubstr("`max_thrust` 50 is more than"));
  EXPECT_THAT(refusal("ctbr", world, {{"pd", false}}), HasSubstr("set `apply: body`"));
  EXPECT_THAT(refusal("wrench", world, {{"links", std::vector<std::string>{"bas"}}}),
              HasSubstr("has no link `bas`"));
  EXPECT_THAT(refusal("wrench", world, {{"links", std::vector<std::string>{"base", "base"}}}),
              HasSubstr("names `base` twice"));
  EXPECT_THAT(refusal("velocity", world,
                      {{"form", "position"}, {"position_min", std::vector<double>{6, 0, 0}}}),
              HasSubstr("`position_min[0]` 6 is not below `position_max[0]` 5"));
  EXPECT_THAT(refusal("position", world, {{"max_acceleration_down", 9.5}}),
              HasSubstr("`max_acceleration_down` 9.5 would leave no thrust"));
}

TEST(ModesOfOtherRobots, NeedRotors) {
  PluginWorld bare;
  bare.add_robot("car", 0, 0, 0);
  bare.add_body(0, "chassis", -1, 1, 1.0, {1, 1, 1});
  for (const char* name : {"rotor_speed", "throttle", "srt", "ctbt", "ctbr", "attitude"}) {
    EXPECT_THAT(refusal(name, bare, {}), HasSubstr("robot `car` has no rotors")) << name;
  }
  EXPECT_THAT(refusal("ctbt", bare, {{"apply", "body"}}), HasSubstr("give ctbt `max_thrust`"));
  bare.robots[0].fixed_base = 1;
  EXPECT_THAT(refusal("velocity", bare, {}), HasSubstr("robot `car` has a fixed base"));
}

}  // namespace
}  // namespace skybody::testing
