// Observation, reward and end of the hover and payload tasks by hand.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;

Group begin(const Instance& task) {
  Group g = task.group(1);
  task.call(Call::kReset, g);
  task.call(Call::kEvaluate, g);
  return g;
}

void step(const Instance& task, Group& g, const Numbers& action) {
  g.action = action;
  ++g.step[0];
  g.end[0] = 0;
  task.call(Call::kEvaluate, g);
}

class HoverTask : public ::testing::Test {
 protected:
  HoverTask() { world.add_quad("quad"); }
  PluginWorld world;
};

TEST_F(HoverTask, GivesTheBitsOfDouble) {
  expect_same_bits("hover", world);
  world.add_quad("second", 1, 0, 1);
  expect_same_bits("hover", world);
}

TEST_F(HoverTask, ObservesTwentyTwoValues) {
  const Instance task("hover", world, {{"target", Numbers{1.0, -2.0, 2.5, 0.3}}});
  EXPECT_EQ(task.declared.channel_count(), 22);
  Group g = begin(task);
  EXPECT_EQ(Numbers(g.observation.begin(), g.observation.begin() + 4),
            (Numbers{1.0, -2.0, 1.5, 0.3}));
  EXPECT_EQ(Numbers(g.observation.begin() + 14, g.observation.end()), Numbers(8, -1.0));
  step(task, g, {0.1, 0.2, 0.3, 0.4});
  step(task, g, {0.5, 0.6, 0.7, 0.8});
  EXPECT_EQ(Numbers(g.observation.begin() + 14, g.observation.end()),
            (Numbers{0.5, 0.6, 0.7, 0.8, 0.1, 0.2, 0.3, 0.4}));
}

TEST_F(HoverTask, WrapsTheYawErrorAndKeepsTheQuaternionsSign) {
  const Instance task("hover", world, {{"target", Numbers{0, 0, 1, 3.0}}});
  Group g = begin(task);
  g.bodies[3] = -std::cos(-1.5);
  g.bodies[6] = -std::sin(-1.5);  // yaw -3, written with w < 0
  task.call(Call::kEvaluate, g);
  EXPECT_NEAR(g.observation[3], 6.0 - 2.0 * 3.141592653589793, 1e-14);
  EXPECT_NEAR(g.observation[7], std::cos(1.5), 1e-15);
  EXPECT_NEAR(g.observation[10], -std::sin(1.5), 1e-15);
}

TEST_F(HoverTask, RewardsAsThePaperDoes) {
  const Instance task("hover", world, {{"target", Numbers{0.3, 0, 1.4, 0.2}}});
  Group g = begin(task);
  g.bodies[11] = 2.0;
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(g.reward[0], 1.0 / (1.0 + 2.56 * (0.09 + 0.16 + 0.04)) + 0.01 / 5.0, 1e-15);
  EXPECT_EQ(g.end[0], 0u);
}

TEST_F(HoverTask, ShapesTheRewardWhereTheScenarioAsksForIt) {
  const double angle = 0.4;
  const auto reward = [&](const std::string& name, double value, double x, double tilt) {
    const Instance task("hover", world, {{"target", Numbers{0, 0, 1, 0}}, {name, Numbers{value}}});
    Group g = begin(task);
    g.bodies[0] = x;
    g.bodies[3] = std::cos(0.5 * tilt);
    g.bodies[4] = std::sin(0.5 * tilt);
    step(task, g, {0, 0, 0, 0});
    return g.reward[0];
  };
  const auto added = [&](const std::string& name, double value, double x, double tilt) {
    return reward(name, value, x, tilt) - reward(name, 0.0, x, tilt);
  };
  // Differences of sums near 1: a few of their last bits.
  EXPECT_NEAR(added("approach_reward", 0.5, 4.0, 0.0), 0.5 * (1.0 - 0.4), 1e-15);
  EXPECT_EQ(added("approach_reward", 0.5, 12.0, 0.0), 0.0) << "no reward is below 0";
  EXPECT_NEAR(added("precision_reward", 2.0, 0.2, 0.0), 1.0, 1e-15);
  EXPECT_NEAR(added("heading_reward", 2.0, 9.0, 0.0), 2.0, 1e-15) << "no yaw error";
  EXPECT_NEAR(added("tilt_cost", 3.0, 0.0, angle), -3.0 * (1.0 / std::cos(angle) - 1.0), 1e-15);
  EXPECT_EQ(added("failure_reward", -8.0, 0.0, angle), 0.0) << "it still flies";
  EXPECT_NEAR(added("failure_reward", -8.0, 7.5, 0.0), -8.0, 1e-15);
}

TEST_F(HoverTask, TerminatesOnTiltYawAndBounds) {
  const Instance task("hover", world);
  const auto ends = [&](int value, double angle, double x) {
    Group g = begin(task);
    g.bodies[0] = x;
    g.bodies[3] = std::cos(0.5 * angle);
    g.bodies[static_cast<std::size_t>(value)] = std::sin(0.5 * angle);
    step(task, g, {0, 0, 0, 0});
    return g.end[0];
  };
  EXPECT_EQ(ends(4, 1.56, 0.0), 0u);
  EXPECT_EQ(ends(4, 1.58, 0.0), 1u);
  EXPECT_EQ(ends(5, -1.58, 0.0), 1u);
  EXPECT_EQ(ends(6, 1.56, 6.99), 0u);
  EXPECT_EQ(ends(6, -1.58, 0.0), 1u);
  EXPECT_EQ(ends(6, 0.0, -7.01), 1u);
}

TEST_F(HoverTask, DrawsTargetsInTheirBoxAndNamesThemAsGoals) {
  const Instance task("hover", world);
  for (std::uint64_t n = 1; n < 500; ++n) {
    Group g = task.group(1);
    g.episode[0] = n;
    task.call(Call::kReset, g);
    const Numbers goal = task.goal(g);
    ASSERT_LE(std::abs(goal[0]), 5.0);
    ASSERT_LE(std::abs(goal[1]), 5.0);
    ASSERT_GE(goal[2], 0.5);
    ASSERT_LE(goal[2], 3.0);
    ASSERT_LE(std::abs(goal[3]), 0.72);
  }
}

TEST_F(HoverTask, ATeamKeepsItsPlacesAndSharesTheReward) {
  world.add_quad("left", 0, 2, 1);
  const Instance task("hover", world, {{"target", Numbers{0, 0, 1, 0}}});
  EXPECT_EQ(task.declared.channel_count(), 44);
  EXPECT_EQ(task.declared.channels[6].name, "left.position_error");
  Group g = begin(task);
  EXPECT_EQ(task.goal(g), (Numbers{0, -1, 1, 0, 0, 1, 1, 0}));
  step(task, g, Numbers(8, 0.0));
  EXPECT_NEAR(g.reward[0], 1.0 / (1.0 + 2.56) + 0.01, 1e-15);  // both are 1 m off
  const Instance one("hover", world, {{"robot", "left"}, {"target", Numbers{0, 0, 1, 0}}});
  EXPECT_EQ(one.declared.channel_count(), 22);
  EXPECT_FALSE(one.declared.task.robot_rewards);  // the other robot's reward would be empty
  EXPECT_EQ(channel_robots(one.declared.channels), std::vector<int>(6, 1));
}

TEST_F(HoverTask, InATeamEveryRobotHasItsOwnObservationAndReward) {
  world.add_quad("left", 0, 2, 1);
  const Instance task("hover", world, {{"target", Numbers{0, 0, 1, 0}}});
  EXPECT_EQ(channel_robots(task.declared.channels),
            (std::vector<int>{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1}));
  EXPECT_TRUE(task.declared.task.robot_rewards);
  EXPECT_EQ(task.declared.task.infos[4].name, "left.position_error");
  Group g = begin(task);
  g.bodies[1] = -1.0;  // the first robot's position
  step(task, g, Numbers(8, 0.0));
  EXPECT_NEAR(g.robot_reward[0], 1.01, 1e-15);
  EXPECT_NEAR(g.robot_reward[1], 1.0 / (1.0 + 2.56) + 0.01, 1e-15);
  EXPECT_NEAR(g.reward[0], 0.5 * (g.robot_reward[0] + g.robot_reward[1]), 1e-15);
}

TEST_F(HoverTask, InformsOfErrorsTiltAndSpeed) {
  const Instance task("hover", world, {{"target", Numbers{0.3, 0, 1.4, -0.2}}});
  EXPECT_EQ(channel_names(task.declared.task.infos),
            (std::vector<std::string>{"position_error", "yaw_error", "tilt", "speed", "failed.tilt",
                                      "failed.heading", "failed.bound", "success"}));
  Group g = begin(task);
  g.bodies[3] = std::cos(0.35);
  g.bodies[4] = std::sin(0.35);
  g.bodies[7] = 3.0;
  g.bodies[9] = -4.0;
  step(task, g, {0, 0, 0, 0});
  const Numbers expected{0.5, 0.2, 0.7, 5.0};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(g.info[k], expected[k], 1e-14) << k;
}

TEST_F(HoverTask, InformsOfAHalfTurnAsPi) {
  const Instance task("hover", world);
  Group g = begin(task);
  g.bodies[3] = 0.0;
  g.bodies[4] = std::sqrt(0.5);
  g.bodies[5] = std::sqrt(0.5);  // upside down; the cosine rounds to less than -1
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(g.info[2], 3.141592653589793, 1e-7);
}

TEST_F(HoverTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("hover", world, {{"target_min", Numbers{0, 0, 4}}}),
              HasSubstr("`target_min[2]` 4"));
  EXPECT_THAT(refusal("hover", world, {{"formation", Numbers{1, 2}}}),
              HasSubstr("`formation` has 2 values for 1 robots"));
  world.robots[0].action_count = 0;
  EXPECT_THAT(refusal("hover", world, {}), HasSubstr("give it a controller"));
}

class PayloadTask : public ::testing::Test {
 protected:
  PayloadTask() {
    world.add_quad("quad", 0, 0, 1.5);
    bob = world.add_payload("bob");
    world.links[1].com[2] = -0.07;
  }
  /// Bob below the robot, both at rest.
  Group at_rest(const Instance& task) const {
    Group g = task.group(1);
    g.bodies[static_cast<std::size_t>(13 * bob + 2)] = 0.6;
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  PluginWorld world;
  int bob = 0;
};

TEST_F(PayloadTask, GivesTheBitsOfDouble) { expect_same_bits("payload", world); }

TEST_F(PayloadTask, ObservesTwentySixValues) {
  const Instance task("payload", world);
  EXPECT_EQ(task.declared.channel_count(), 26);
  Group g = at_rest(task);
  EXPECT_NEAR(g.observation[2], 0.53 - 0.5, 1e-15);
  EXPECT_NEAR(g.observation[5], 0.53 - 1.5, 1e-15);
  EXPECT_EQ(g.observation[6], 1.0);
  EXPECT_EQ(g.observation[25], -1.0);
  g.bodies[static_cast<std::size_t>(13 * bob + 10)] =
      2.0;  // about x: the centre of mass moves along +y
  step(task, g, {0.1, 0.2, 0.3, 0.4});
  EXPECT_NEAR(g.observation[17], 2.0 * 0.07, 1e-15);
  EXPECT_EQ(g.observation[19], 2.0);
  EXPECT_EQ(g.observation[25], 0.4);
}

TEST_F(PayloadTask, RewardsAsThePaperDoesAndPunishesFailure) {
  const Instance task("payload", world);
  Group g = at_rest(task);
  g.bodies[static_cast<std::size_t>(13 * bob + 12)] = 1.0;
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(g.reward[0], 1.0 / (1.0 + 1.6 * 0.0009) + 0.1 / 2.0, 1e-12);
  g.bodies[0] = 7.5;
  step(task, g, {0, 0, 0, 0});
  EXPECT_EQ(g.reward[0], -50.0);
  EXPECT_EQ(g.end[0], 1u);
}

TEST_F(PayloadTask, InformsOfErrorTiltAndSpeed) {
  const Instance task("payload", world);
  EXPECT_EQ(channel_names(task.declared.task.infos),
            (std::vector<std::string>{"payload_error", "tilt", "speed", "failed.tilt",
                                      "failed.heading", "failed.bound", "success"}));
  EXPECT_EQ(channel_robots(task.declared.channels), std::vector<int>(8, 0));
  Group g = at_rest(task);
  g.bodies[3] = std::cos(0.1);
  g.bodies[5] = std::sin(0.1);
  g.bodies[8] = -2.0;
  step(task, g, {0, 0, 0, 0});
  const Numbers expected{0.03, 0.2, 2.0};
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(g.info[k], expected[k], 1e-14) << k;
}

TEST_F(PayloadTask, TheGoalPutsTheCentreOfMassOnTheTarget) {
  const Instance task("payload", world);
  ASSERT_EQ(task.declared.task.goals.size(), 1u);
  EXPECT_EQ(task.declared.task.goals[0].body, bob);
  Group g = at_rest(task);
  const Numbers goal = task.goal(g);
  EXPECT_NEAR(goal[2], 0.57, 1e-15);
}

TEST_F(PayloadTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("payload", world, {{"payload_link", "crate"}}),
              HasSubstr("has no link `crate`: there are base, bob"));
  EXPECT_THAT(refusal("payload", world, {{"payload_link", "base"}}),
              HasSubstr("name one that hangs on a joint"));
}

}  // namespace
}  // namespace skybody::testing
