// The race through gates, by hand.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

constexpr double kPi = 3.141592653589793;
/// Arithmetic on a few metres: some roundings of 1e-16.
constexpr double kRounding = 1e-14;

/// A square lap: two gates along x, 4 m apart and facing each other's backs.
class RacingTask : public ::testing::Test {
 protected:
  RacingTask() {
    world.add_quad("quad", -2, 0, 1);
    world.add_gate("first", {0, 0, 1}, 0.0);
    world.add_gate("second", {0, 4, 1}, kPi, 1.0, 2.0);
  }
  Group begin(const Instance& task, const Numbers& at = {-2, 0, 1}) const {
    Group g = task.group(1);
    put(g, at);
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  static void put(Group& g, const Numbers& p, int robot = 0) {
    for (std::size_t k = 0; k < 3; ++k) g.bodies[13 * static_cast<std::size_t>(robot) + k] = p[k];
  }
  static void step(const Instance& task, Group& g, const Numbers& p, int robot = 0) {
    put(g, p, robot);
    ++g.step[0];
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
  /// An info's value.
  static double info(const Instance& task, const Group& g, const std::string& name) {
    std::size_t first = 0;
    for (const Channel& c : task.declared.task.infos) {
      if (c.name == name) return g.info[first];
      first += static_cast<std::size_t>(c.count);
    }
    ADD_FAILURE() << "no info " << name;
    return 0.0;
  }
  PluginWorld world;
  const Parameters free{{"tilt_max", kPi}, {"yaw_max", 4.0}, {"rate_cost", 0.0}};
};

TEST_F(RacingTask, GivesTheBitsOfDouble) {
  expect_same_bits("racing", world);
  world.add_quad("other", -2, 1, 1);
  expect_same_bits("racing", world, {{"rivalry", 0.5}, {"laps", 2}, {"first_gate", 1.0}});
}

TEST_F(RacingTask, ObservesTheNextTwoGatesFromTheBody) {
  const Instance task("racing", world, free);
  EXPECT_EQ(task.declared.channel_count(), 25);
  Group g = task.group(1);
  g.bodies[3] = g.bodies[6] = std::sqrt(0.5);  // it faces y
  for (std::size_t k = 0; k < 6; ++k) g.bodies[7 + k] = static_cast<double>(k + 1);
  put(g, {-2, 0.5, 0.8});
  g.action = {0.1, 0.2, 0.3, 0.4};
  g.step[0] = 1;
  task.call(Call::kEvaluate, g);
  const Numbers expected{-0.5, -2, 0.2, 0, -1, 0,  // first gate: centre and normal
                         3.5,  -2, 0.2, 0, 1,  0,  // second
                         2,    -1, 3,   0, 0,  1, 4, 5, 6, 0.1, 0.2, 0.3, 0.4};
  ASSERT_EQ(g.observation.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_NEAR(g.observation[k], expected[k], kRounding) << k;
}

TEST_F(RacingTask, ShowsNoActionAtAReset) {
  const Instance task("racing", world, free);
  const Group g = begin(task);
  EXPECT_EQ(Numbers(g.observation.end() - 4, g.observation.end()), Numbers(4, -1.0));
}

TEST_F(RacingTask, PaysForComingNearerTheNextGate) {
  const Instance task("racing", world, free);
  Group g = begin(task);
  step(task, g, {-1.5, 0, 1});
  EXPECT_NEAR(g.reward[0], 0.5, kRounding);
  step(task, g, {-2.5, 0, 1});
  EXPECT_NEAR(g.reward[0], -1.0, kRounding);
  EXPECT_EQ(g.end[0], 0u);
}

TEST_F(RacingTask, TakesSpinningOff) {
  const Instance task("racing", world, {{"rate_cost", 0.01}, {"tilt_max", kPi}});
  Group g = begin(task);
  g.bodies[10] = 3.0;
  step(task, g, {-2, 0, 1});
  EXPECT_NEAR(g.reward[0], -0.09, kRounding);
}

TEST_F(RacingTask, PassesAGateWhereTheSignOfTheDistanceTurnsWithinTheOpening) {
  const Instance task("racing", world, free);
  Group g = begin(task);
  step(task, g, {-0.1, 0.1, 1});
  EXPECT_EQ(info(task, g, "gates_passed"), 0.0);
  step(task, g, {0.1, 0.1, 1});
  EXPECT_EQ(info(task, g, "gates_passed"), 1.0);
  EXPECT_NEAR(g.reward[0], 1.0, kRounding) << "as far from its centre as before, and the gate";
  EXPECT_NEAR(g.observation[1], 3.9, kRounding) << "the second one is next";
  step(task, g, {0.3, 0.1, 1});
  EXPECT_NEAR(g.reward[0], std::hypot(0.1, 3.9) - std::hypot(0.3, 3.9), kRounding)
      << "progress counts from the new gate";
}

TEST_F(RacingTask, DoesNotPassAGateBackwards) {
  const Instance task("racing", world, free);
  Group g = begin(task, {0.5, 0, 1});
  step(task, g, {-0.5, 0, 1});
  EXPECT_EQ(info(task, g, "gates_passed"), 0.0);
  EXPECT_EQ(g.end[0], 0u);
  EXPECT_EQ(info(task, g, "failed.missed"), 0.0);
}

TEST_F(RacingTask, DecidesByThePlaceWhereTheWayCrossesThePlane) {
  const Instance task("racing", world, {{"tilt_max", kPi}, {"radius", 0.0}});
  Group g = begin(task, {-1, 1.2, 1});
  step(task, g, {1, 0.0, 1});
  EXPECT_EQ(info(task, g, "gates_passed"), 1.0) << "crosses at 0.6 m of 0.7 m";
  g = begin(task, {-1, 1.8, 1});
  step(task, g, {1, 0.0, 1});
  EXPECT_EQ(info(task, g, "gates_passed"), 0.0) << "crosses at 0.9 m";
  EXPECT_EQ(info(task, g, "failed.missed"), 1.0);
  EXPECT_EQ(g.end[0], 1u);
}

TEST_F(RacingTask, TellsTheTimeOfEachLapAndEndsWithTheLast) {
  world.dt = 0.5;
  Parameters two = free;
  two.insert({"laps", 2});
  const Instance task("racing", world, two);
  Group g = begin(task);
  const auto lap = [&] {
    step(task, g, {-0.5, 0, 1});
    step(task, g, {0.5, 0, 1});
    step(task, g, {0.5, 4, 1});
    step(task, g, {-0.5, 4, 1});
  };
  EXPECT_EQ(info(task, g, "lap_time"), 0.0);
  lap();
  EXPECT_EQ(info(task, g, "lap_time"), 2.0);
  EXPECT_EQ(g.end[0], 0u);
  step(task, g, {-1, 4, 1});
  lap();
  EXPECT_EQ(info(task, g, "lap_time"), 2.5);
  EXPECT_EQ(info(task, g, "success"), 1.0);
  EXPECT_EQ(g.end[0], 1u);
}

TEST_F(RacingTask, FailsByTouchingAFrameOrTheGround) {
  const Instance task("racing", world, free);
  const auto failure = [&](const Numbers& p, const std::string& name) {
    Group g = begin(task, p);
    step(task, g, p);
    EXPECT_EQ(g.end[0], info(task, g, name) == 1.0 ? 1u : 0u);
    EXPECT_EQ(g.reward[0], info(task, g, name) == 1.0 ? -10.0 : 0.0);
    return info(task, g, name) == 1.0;
  };
  EXPECT_FALSE(failure({0, 0.45, 1}, "failed.collision")) << "0.25 m from the left bar";
  EXPECT_TRUE(failure({0, 0.55, 1}, "failed.collision")) << "0.15 m from it";
  EXPECT_TRUE(failure({0, 0, 1.6}, "failed.collision")) << "0.1 m below the upper bar";
  EXPECT_TRUE(failure({0, 0.75, 1}, "failed.collision")) << "in a bar";
  EXPECT_TRUE(failure({-0.2, 0.75, 1}, "failed.collision")) << "0.15 m before a bar";
  EXPECT_FALSE(failure({-0.3, 0.75, 1}, "failed.collision")) << "0.25 m before it";
  EXPECT_TRUE(failure({0, 0.9, 1.9}, "failed.collision")) << "0.14 m from a corner";
  EXPECT_FALSE(failure({0, 0.95, 1.95}, "failed.collision")) << "0.21 m from it";
  EXPECT_TRUE(failure({0, 3.45, 1}, "failed.collision")) << "0.05 m from the other gate";
  EXPECT_TRUE(failure({-2, 0, 0.05}, "failed.ground"));
  EXPECT_TRUE(failure({-7.5, 0, 1}, "failed.bound"));
}

TEST_F(RacingTask, FailsByTiltAndHeadingWhereTheScenarioLimitsThem) {
  const Instance task("racing", world);
  Group g = begin(task);
  g.bodies[3] = std::cos(0.8);
  g.bodies[4] = std::sin(0.8);
  step(task, g, {-2, 0, 1});
  EXPECT_EQ(info(task, g, "failed.tilt"), 1.0);
  g = begin(task);
  g.bodies[3] = std::cos(0.8);
  g.bodies[6] = std::sin(0.8);
  step(task, g, {-2, 0, 1});
  EXPECT_EQ(info(task, g, "failed.heading"), 1.0);
}

TEST_F(RacingTask, TwoRacersGainWhatTheOtherLosesAndSeeEachOther) {
  world.add_quad("other", -2, 1, 1);
  Parameters duel = free;
  duel.insert({"rivalry", 0.5});
  const Instance task("racing", world, duel);
  EXPECT_EQ(task.declared.channel_count(), 2 * (25 + 7));
  EXPECT_EQ(task.declared.channels[8].name, "quad.other.offset");
  Group g = begin(task);
  put(g, {-2, 0.6, 1}, 1);
  g.buffer.assign(g.buffer.size(), 0.0);
  g.step[0] = 0;
  task.call(Call::kEvaluate, g);
  EXPECT_EQ(g.end[0], 0u);
  step(task, g, {-1.5, 0, 1});
  EXPECT_NEAR(g.robot_reward[0], 0.5, kRounding);
  EXPECT_NEAR(g.robot_reward[1], -0.25, kRounding);
  EXPECT_NEAR(g.reward[0], 0.125, kRounding) << "their mean";
  EXPECT_NEAR(g.observation[25], -0.5, kRounding);
  EXPECT_NEAR(g.observation[26], 0.6, kRounding);
  step(task, g, {-2, 0.3, 1});
  EXPECT_EQ(info(task, g, "failed.collision"), 1.0) << "0.3 m apart, 0.2 m each";
  EXPECT_NEAR(g.robot_reward[0], std::hypot(2, 0.3) * -1.0 + 1.5 - 10.0, kRounding);
}

TEST_F(RacingTask, LeadsTheBaselineOnTheAxisAndLetsItWaitAside) {
  Parameters paced = free;
  paced.insert({"pace", 2.0});
  const Instance task("racing", world, paced);
  Group g = begin(task, {-2, 0.1, 1});
  Numbers goal = task.goal(g), motion = task.goal_motion(g);
  EXPECT_NEAR(goal[0], -2.0, kRounding);
  EXPECT_NEAR(goal[1], 0.0, kRounding);
  EXPECT_NEAR(motion[0], 2.0, kRounding);
  g = begin(task, {-0.2, 1.2, 1});  // 1 m outside the lateral limit: back to -1 m
  goal = task.goal(g);
  motion = task.goal_motion(g);
  EXPECT_NEAR(goal[0], -0.2 + 0.7 - 1.5, kRounding);
  EXPECT_EQ(motion[0], 0.0);
}

TEST_F(RacingTask, BeginsAtTheGateThatWasDrawn) {
  const Instance task("racing", world, free);
  Group g = task.group(1);
  g.params[static_cast<std::size_t>(task.env_param("first_gate"))] = 1.0;
  task.call(Call::kReset, g);
  task.call(Call::kEvaluate, g);
  EXPECT_NEAR(g.observation[1], 4.0, kRounding) << "the second gate is next";
  EXPECT_NEAR(g.observation[7], 0.0, kRounding) << "and the first follows";
}

TEST_F(RacingTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("racing", world, {{"gates", std::vector<std::string>{"frist"}}}),
              HasSubstr("names no gate `frist`: there are first, second"));
  EXPECT_THAT(refusal("racing", world, {{"gates", std::vector<std::string>{"first", "first"}}}),
              HasSubstr("`gates` names `first` twice"));
  EXPECT_THAT(refusal("racing", world, {{"robots", std::vector<std::string>{"quat"}}}),
              HasSubstr("no robot `quat`: there are quad"));
  EXPECT_THAT(refusal("racing", world, {{"robots", std::vector<std::string>{"quad", "quad"}}}),
              HasSubstr("robot `quad` is named twice"));
  EXPECT_THAT(refusal("racing", world, {{"first_gate", 2.0}}),
              HasSubstr("`first_gate` is 2; allowed: whole numbers from 0 to 1"));
  EXPECT_THAT(refusal("racing", world, {{"first_gate", 0.5}}), HasSubstr("`first_gate` is 0.5"));
  world.robots[0].action_count = 0;
  EXPECT_THAT(refusal("racing", world, {}), HasSubstr("no robot takes actions"));
}

TEST_F(RacingTask, RefusesTracksThatNobodyCanFly) {
  PluginWorld empty;
  empty.add_quad("quad");
  EXPECT_THAT(refusal("racing", empty, {}), HasSubstr("there is no gate to race through"));
  world.add_gate("third", {-4, 4.5, 1}, 0.0);
  EXPECT_THAT(refusal("racing", world, {}),
              HasSubstr("gate `third` faces away from `second`: whoever leaves that one is 3.5 m "
                        "behind the plane of this one"));
  PluginWorld near;
  near.add_quad("quad");
  near.add_gate("one", {0, 0, 1}, 0.0);
  near.add_gate("next", {0.3, 0, 1}, 0.0);
  EXPECT_THAT(
      refusal("racing", near, {}),
      HasSubstr("gate `next` stands 0.3 m behind `one`; allowed: 0.5 m or more. Move it on"));
  PluginWorld crossed;
  crossed.add_quad("quad");
  crossed.add_gate("upright", {0, 0, 1}, 0.0);
  crossed.add_gate("across", {0.5, 0.2, 1}, 0.5 * kPi);
  EXPECT_THAT(refusal("racing", crossed, {}),
              HasSubstr("gate `across` at [0.5, 0.2, 1] m overlaps `upright` at [0, 0, 1] m"));
}

TEST_F(RacingTask, RefusesGatesInTheGroundAndTooNarrowOnes) {
  EXPECT_THAT(refusal("racing", world, {{"radius", 0.5}}),
              HasSubstr("gate `second` opens 1 m by 2 m, and nearer than `radius` 0.5 m to its "
                        "frame a racer collides: let it open more than 1 m each way"));
  EXPECT_THAT(refusal("racing", world, {{"height_min", 1.5}}),
              HasSubstr("gate `first` has its middle at z = 1 m, below `height_min` 1.5"));
  world.add_gate("low", {4, 0, 0.5}, 0.0, 1.4, 1.5);
  const Parameters alone = {{"gates", std::vector<std::string>{"low"}}};
  EXPECT_THAT(refusal("racing", world, alone),
              HasSubstr("gate `low` opens down to z = -0.25 m, below the ground: lift it by 0.25 "
                        "m"));
}

TEST_F(RacingTask, RefusesRivalryOfOneRacerAndLanesBesideGates) {
  EXPECT_THAT(refusal("racing", world, {{"rivalry", 0.5}}),
              HasSubstr("`rivalry` is 0.5, and there is one racer"));
  world.add_quad("rival", -2, 1, 1);
  EXPECT_THAT(refusal("racing", world, {{"lane_width", 2.0}}),
              HasSubstr("`lane_width` 2 leads racers 1 m aside, and gate `first` lets those of "
                        "`radius` 0.2 be 0.5 m aside: take at most 1"));
}

}  // namespace
}  // namespace skybody::testing
