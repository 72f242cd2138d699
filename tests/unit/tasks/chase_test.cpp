// The chase, by hand: visibility, rewards of each robot, ends, goals of the baseline.
#include <algorithm>
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

/// Sums of a few numbers near 1: some roundings of 2e-16.
constexpr double kRounding = 1e-14;

class ChaseTask : public ::testing::Test {
 protected:
  ChaseTask() {
    world.add_quad("hawk", 2, 0, 1);
    world.add_quad("evader", 0, 0, 1);
    world.add_quad("kite", -3, 0, 1);
  }
  /// Makes the evader follow a reference.
  void be_scripted() {
    world.robots[1].action_count = 0;
    world.robots[2].first_action = 4;
  }
  static Group begin(const Instance& task) {
    Group g = task.group(1);
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  static void put(Group& g, int robot, const Numbers& to) {
    for (std::size_t k = 0; k < 3; ++k) g.bodies[static_cast<std::size_t>(13 * robot) + k] = to[k];
  }
  static void step(const Instance& task, Group& g) {
    ++g.step[0];
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
  static double info(const Instance& task, const Group& g, const std::string& name) {
    const auto names = channel_names(task.declared.task.infos);
    const auto at = std::find(names.begin(), names.end(), name);
    EXPECT_NE(at, names.end()) << name;
    return g.info[static_cast<std::size_t>(at - names.begin())];
  }
  PluginWorld world;
};

TEST_F(ChaseTask, GivesTheBitsOfDouble) {
  expect_same_bits("chase", world);
  be_scripted();
  expect_same_bits("chase", world, {{"capture_radius", 0.2}});
}

TEST_F(ChaseTask, PursuersSeeTheEvaderFirst) {
  be_scripted();
  const Instance task("chase", world);
  EXPECT_EQ(
      channel_names(task.declared.channels),
      (std::vector<std::string>{
          "hawk.position", "hawk.velocity", "hawk.attitude", "hawk.angular_velocity",
          "hawk.evader.offset", "hawk.evader.velocity", "hawk.kite.offset", "hawk.kite.velocity",
          "kite.position", "kite.velocity", "kite.attitude", "kite.angular_velocity",
          "kite.evader.offset", "kite.evader.velocity", "kite.hawk.offset", "kite.hawk.velocity"}));
  EXPECT_EQ(channel_robots(task.declared.channels),
            (std::vector<int>{0, 0, 0, 0, 0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 2, 2}));
  Group g = begin(task);
  g.bodies[13 + 8] = 1.5;  // the evader's velocity
  g.bodies[7] = 0.5;       // the hawk's
  task.call(Call::kEvaluate, g);
  EXPECT_EQ(Numbers(g.observation.begin() + 13, g.observation.begin() + 25),
            (Numbers{-2, 0, 0, -0.5, 1.5, 0, -5, 0, 0, -0.5, 0, 0}));
}

TEST_F(ChaseTask, AnEvaderThatActsSeesAsManyValuesAndKnowsItsPart) {
  const Instance task("chase", world);
  EXPECT_EQ(task.declared.channel_count(), 3 * 26);
  const Group g = begin(task);
  EXPECT_EQ(g.observation[13], 0.0) << "the hawk pursues";
  EXPECT_EQ(g.observation[26 + 13], 0.0) << "and so does the kite";
  EXPECT_EQ(g.observation[52 + 13], 1.0) << "the evader's row is the last";
  EXPECT_EQ(Numbers(g.observation.begin() + 52 + 14, g.observation.begin() + 52 + 17),
            (Numbers{2, 0, 0}));
}

TEST_F(ChaseTask, RewardsEachPursuerForItsOwnWayAndTheEvaderForTheNearest) {
  const Instance task("chase", world);
  Group g = begin(task);
  put(g, 0, {1.5, 0, 1});
  put(g, 2, {-3.25, 0, 1});
  step(task, g);
  EXPECT_NEAR(g.robot_reward[0], 0.5 - 0.02, kRounding);
  EXPECT_NEAR(g.robot_reward[2], -0.25 - 0.02, kRounding);
  EXPECT_NEAR(g.robot_reward[1], -0.5 + 0.02, kRounding);
  EXPECT_NEAR(g.reward[0], 0.125 - 0.02, kRounding) << "the team's is the pursuers' mean";
}

TEST_F(ChaseTask, ChargesForCrowdingAndTurning) {
  const Instance task("chase", world);
  Group g = begin(task);
  put(g, 2, {2.0, 0.6, 1});
  step(task, g);
  const double crowd = 0.2 * 0.25 * 0.25;
  EXPECT_NEAR(g.robot_reward[0], -0.02 - crowd, kRounding);
  g.bodies[10] = 2.0;
  step(task, g);
  EXPECT_NEAR(g.robot_reward[0], -0.02 - crowd - 0.004, kRounding);
}

TEST_F(ChaseTask, ACaptureEndsWithSuccess) {
  const Instance task("chase", world);
  Group g = begin(task);
  EXPECT_EQ(g.end[0], 0u);
  put(g, 0, {0.4, 0, 1});
  step(task, g);
  EXPECT_EQ(g.end[0], 1u);
  EXPECT_EQ(info(task, g, "success"), 1.0);
  EXPECT_NEAR(info(task, g, "evader_distance"), 0.4, kRounding);
  EXPECT_NEAR(g.robot_reward[0], 1.6 - 0.02 + 5.0, kRounding);
  EXPECT_NEAR(g.robot_reward[2], -0.02 + 5.0, kRounding) << "the others have their part in it";
  EXPECT_NEAR(g.robot_reward[1], -1.6 + 0.02 - 5.0, kRounding);
}

TEST_F(ChaseTask, EachFailureEndsAndIsNamed) {
  const Instance task("chase", world);
  const auto failed = [&](int robot, const Numbers& at, const std::string& name) {
    Group g = begin(task);
    put(g, robot, at);
    step(task, g);
    EXPECT_EQ(g.end[0], 1u) << name;
    EXPECT_EQ(info(task, g, "failed." + name), 1.0) << name;
    EXPECT_EQ(info(task, g, "success"), 0.0) << name;
    return g.robot_reward;
  };
  EXPECT_LT(failed(0, {2, 0, 0.1}, "ground")[0], -4.0);
  EXPECT_LT(failed(2, {-7.5, 0, 1}, "bound")[2], -4.0);
  EXPECT_GT(failed(2, {-7.5, 0, 1}, "bound")[0], -1.0) << "the hawk has done nothing";
  EXPECT_LT(failed(2, {1.7, 0, 1}, "separation")[2], -3.0);
  EXPECT_LT(failed(1, {0, 0, 0.1}, "evader")[1], -4.0);
  Group g = begin(task);
  g.bodies[3] = 0.0;
  g.bodies[4] = 1.0;  // upside down
  step(task, g);
  EXPECT_EQ(info(task, g, "failed.tilt"), 1.0);
  g.bodies[4] = 0.0;
  g.bodies[6] = 1.0;  // facing back
  step(task, g);
  EXPECT_EQ(info(task, g, "failed.heading"), 1.0);
}

TEST_F(ChaseTask, LeadsTheFirstPursuerToTheEvaderAndOthersBesideIt) {
  be_scripted();
  const Instance task("chase", world);
  Group g = begin(task);
  ASSERT_EQ(task.declared.task.goals.size(), 2u) << "none of an evader that follows a reference";
  const Numbers goal = task.goal(g);
  EXPECT_EQ(Numbers(goal.begin(), goal.begin() + 3), (Numbers{0, 0, 1}));
  EXPECT_NEAR(goal[4], -1.0, kRounding);
  g.bodies[13 + 7] = 1.25;
  EXPECT_EQ(task.goal_motion(g), (Numbers{1.25, 0, 0, 0, 0, 0, 1.25, 0, 0, 0, 0, 0}));
}

TEST_F(ChaseTask, LeadsAnEvaderAwayWithinItsPen) {
  const Instance task("chase", world);
  Group g = begin(task);
  put(g, 1, {2.5, 1.0, 1.5});
  put(g, 0, {2.5, 0.0, 1.5});
  put(g, 2, {2.5, -1.0, 1.5});
  const Numbers goal = task.goal(g);
  EXPECT_NEAR(goal[8], 2.5, kRounding);
  EXPECT_NEAR(goal[9], 2.0, kRounding) << "straight away, one metre";
  put(g, 1, {2.5, 2.8, 1.5});
  EXPECT_NEAR(task.goal(g)[9], 3.0, kRounding) << "not past the pen";
}

TEST_F(ChaseTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("chase", world, {{"evader", "hare"}}), HasSubstr("hare"));
  world.robots[2].action_count = 0;
  EXPECT_THAT(refusal("chase", world, {}),
              HasSubstr("robot `kite` takes no action, so that it cannot pursue: give it a "
                        "controller, such as `ctbr`, or take it out"));
  PluginWorld alone;
  alone.add_quad("evader");
  EXPECT_THAT(refusal("chase", alone, {}),
              HasSubstr("there is nobody to pursue `evader`: a chase needs two robots or more"));
}

}  // namespace
}  // namespace skybody::testing
