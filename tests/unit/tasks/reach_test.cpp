// The task of an arm's tool, by hand.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

/// A quad at (1, 2, 3) that faces y, with an arm of two links.
class ReachTask : public ::testing::Test {
 protected:
  ReachTask() {
    world.add_quad("quad", 1, 2, 3);
    world.robots[0].rotation[0] = world.robots[0].rotation[3] = std::sqrt(0.5);
    world.add_arm_link("upper");
    lower = world.add_arm_link("lower");
    world.links.back().position[2] = -0.2;
  }
  /// At rest at home, the tool straight below at the height z above W.
  Group at_rest(const Instance& task, double z) const {
    Group g = task.group(1);
    g.bodies[3] = g.bodies[6] = std::sqrt(0.5);
    g.bodies[static_cast<std::size_t>(13 * lower + 2)] = z + 0.2;
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  PluginWorld world;
  const Parameters given{{"tool", "lower"}, {"place", Numbers{0.1, 0.0, -0.4}}, {"yaw_max", 3.0}};
  int lower = 0;
};

TEST_F(ReachTask, GivesTheBitsOfDouble) { expect_same_bits("reach", world, given); }

TEST_F(ReachTask, MeansPlacesInTheHeadingOfTheScenariosPose) {
  const Instance task("reach", world, given);
  EXPECT_EQ(task.declared.channel_count(), 28);
  const Group g = at_rest(task, 2.5);
  // Positions are sums of a few numbers near 1: 1e-15 is some roundings of them.
  EXPECT_NEAR(g.observation[0], 0.0, 1e-15) << "x of the vehicle is y of the world";
  EXPECT_NEAR(g.observation[1], 0.1, 1e-15);
  EXPECT_NEAR(g.observation[2], 0.1, 1e-15) << "2.6 m less 2.5 m";
  for (std::size_t k = 6; k < 10; ++k) EXPECT_NEAR(g.observation[k], 0.0, 1e-15) << "at home";
}

TEST_F(ReachTask, NamesTheToolAsThePointOfItsGoal) {
  const Instance task("reach", world, given);
  ASSERT_EQ(task.declared.task.goals.size(), 1u);
  EXPECT_EQ(task.declared.task.goals[0].body, lower);
  EXPECT_EQ(task.declared.task.goals[0].point.z, -0.2);
  Group g = at_rest(task, 2.5);
  const Numbers goal = task.goal(g);
  EXPECT_NEAR(goal[0], 1.0, 1e-15);
  EXPECT_NEAR(goal[1], 2.1, 1e-15);
  EXPECT_NEAR(goal[2], 2.8, 1e-15) << "the frame of the link, 0.2 m above the tool";
  EXPECT_NEAR(goal[3], 0.5 * 3.141592653589793, 1e-15) << "the vehicle's heading";
}

TEST_F(ReachTask, ObservesTheArmsJointsFromTheBaseOn) {
  const Instance task("reach", world, given);
  Group g = at_rest(task, 2.6);
  g.q[static_cast<std::size_t>(world.bodies[1].first_q)] = 0.3;
  g.q[static_cast<std::size_t>(world.bodies[2].first_q)] = -0.7;
  g.u[static_cast<std::size_t>(world.bodies[1].first_u)] = 1.5;
  g.u[static_cast<std::size_t>(world.bodies[2].first_u)] = -2.5;
  task.call(Call::kEvaluate, g);
  EXPECT_EQ(Numbers(g.observation.begin() + 20, g.observation.begin() + 24),
            (Numbers{0.3, -0.7, 1.5, -2.5}));
  EXPECT_EQ(Numbers(g.observation.begin() + 24, g.observation.end()), Numbers(4, -1.0));
}

TEST_F(ReachTask, ObservesTheToolsVelocity) {
  const Instance task("reach", world, given);
  Group g = at_rest(task, 2.6);
  const auto first = static_cast<std::size_t>(13 * lower);
  g.bodies[first + 7] = 1.0;
  g.bodies[first + 11] = 2.0;  // about y: the end, 0.2 m below, moves along -x at 0.4 m/s
  task.call(Call::kEvaluate, g);
  EXPECT_NEAR(g.observation[3], 0.6, 1e-15);
}

TEST_F(ReachTask, RewardsTheToolOnlyWhereTheVehicleHoldsItsPlace) {
  const Instance task("reach", world, given);
  Group g = at_rest(task, 2.5);
  const double tool = 1.0 / (1.0 + 100.0 * (0.01 + 0.01));
  EXPECT_NEAR(g.reward[0], tool + 0.01, 1e-14);
  g.bodies[0] += 0.5;
  task.call(Call::kEvaluate, g);
  EXPECT_NEAR(g.reward[0], tool / (1.0 + 2.56 * 0.25) + 0.01, 1e-14);
  EXPECT_NEAR(g.info[0], std::sqrt(0.02), 1e-15);
  EXPECT_NEAR(g.info[1], 0.5, 1e-15);
}

TEST_F(ReachTask, EndsAndPunishesAFailure) {
  const Instance task("reach", world, {{"tool", "lower"}});
  Group g = at_rest(task, 2.6);
  EXPECT_EQ(g.end[0], 0u) << "the scenario's heading, pi / 2, is home";
  g.bodies[6] = -g.bodies[6];
  task.call(Call::kEvaluate, g);
  EXPECT_EQ(g.end[0], 1u) << "turned by pi, beyond the default yaw_max of 1.57";
  EXPECT_EQ(g.reward[0], -50.0);
}

TEST_F(ReachTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("reach", world, {{"tool", "gripper"}}), HasSubstr("gripper"));
  EXPECT_THAT(refusal("reach", world, {{"tool", "base"}}),
              HasSubstr("link `base` is fixed to the base of robot `quad`: name one that an arm "
                        "moves"));
  world.bodies[1].joint = SKYBODY_BALL;
  EXPECT_THAT(refusal("reach", world, given),
              HasSubstr("joint `upper_joint` of robot `quad` is neither revolute nor prismatic"));
}

}  // namespace
}  // namespace skybody::testing
