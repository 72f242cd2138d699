// Observation, reward and end of the pendulum task by hand.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;

constexpr double kHeight = 1.5;   // of the base [m]
constexpr double kJoint = 0.03;   // above the base [m]
constexpr double kCenter = 1.07;  // of the bob above the joint [m]
constexpr double kTop = kHeight + kJoint + kCenter;

class PendulumTask : public ::testing::Test {
 protected:
  PendulumTask() {
    world.add_quad("quad", 0, 0, kHeight);
    bob = world.add_payload("bob");
    world.links[1].com[2] = kCenter;
  }
  /// The pendulum above the robot, both at rest.
  Group upright(const Instance& task) const {
    Group g = task.group(1);
    g.bodies[at(2)] = kHeight + kJoint;
    g.before = g.bodies;
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  static void step(const Instance& task, Group& g, const Numbers& action = {0, 0, 0, 0}) {
    g.action = action;
    ++g.step[0];
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
  /// Rotates the pendulum about x by an angle [rad] on its joint.
  void lean(Group& g, double angle) const {
    g.bodies[at(3)] = std::cos(0.5 * angle);
    g.bodies[at(4)] = std::sin(0.5 * angle);
  }
  /// Index of value k of the bob's body.
  std::size_t at(int k) const { return static_cast<std::size_t>(13 * bob + k); }

  PluginWorld world;
  int bob = 0;
};

TEST_F(PendulumTask, GivesTheBitsOfDouble) {
  expect_same_bits("pendulum", world);
  expect_same_bits("pendulum", world, {{"history", 3}, {"privileged", false}});
}

TEST_F(PendulumTask, ObservesTenStepsAndShowsACriticTwentySixDerivativesOfEach) {
  const Instance task("pendulum", world);
  int observed = 0, privileged = 0;
  for (const Channel& c : task.declared.channels) (c.privileged ? privileged : observed) += c.count;
  EXPECT_EQ(observed, 10 * 22 + 10 * 4);
  EXPECT_EQ(privileged, 10 * 26 + 6);
  EXPECT_EQ(
      channel_names(task.declared.channels),
      (std::vector<std::string>{"bob_error", "bob_offset", "bob_velocity", "bob_angular_velocity",
                                "velocity", "attitude", "angular_velocity", "actions",
                                "base_derivative", "bob_derivative", "mass", "inertia", "lags"}));
}

TEST_F(PendulumTask, APastBeginsAsTheFirstMomentAndGrowsOlder) {
  const Instance task("pendulum", world, {{"history", 3}, {"privileged", false}});
  ASSERT_EQ(task.declared.channel_count(), 3 * 26);
  Group g = upright(task);
  const std::size_t actions = 3 * 22;
  for (std::size_t age = 0; age < 3; ++age) {
    EXPECT_NEAR(g.observation[3 * age + 2], kTop - 2.0, 1e-15);
    EXPECT_NEAR(g.observation[9 + 3 * age + 2], kJoint + kCenter, 1e-15);
    EXPECT_EQ(g.observation[actions + 4 * age], -1.0);
  }
  g.bodies[at(0)] = 0.25;
  step(task, g, {0.1, 0.2, 0.3, 0.4});
  EXPECT_EQ(Numbers(g.observation.begin(), g.observation.begin() + 9),
            (Numbers{0.25, 0, g.observation[2], 0, 0, g.observation[2], 0, 0, g.observation[2]}));
  EXPECT_EQ(Numbers(g.observation.begin() + actions, g.observation.begin() + actions + 8),
            (Numbers{0.1, 0.2, 0.3, 0.4, -1, -1, -1, -1}));
}

TEST_F(PendulumTask, TheBobIsItsLinksCentreOfMass) {
  const Instance task("pendulum", world, {{"history", 1}, {"privileged", false}});
  Group g = upright(task);
  g.bodies[at(11)] = 2.0;  // about y: points above the joint move along +x
  g.bodies[3] = -1.0;      // the same attitude, written with w < 0
  step(task, g);
  EXPECT_NEAR(g.observation[6], 2.0 * kCenter, 1e-15);
  EXPECT_EQ(g.observation[10], 2.0);
  EXPECT_EQ(g.observation[15], 1.0);
}

TEST_F(PendulumTask, DerivativesAreThoseOfTheLastPhysicsStep) {
  const Instance task("pendulum", world, {{"history", 1}});
  const std::size_t base = 26, top = 39, constants = 52;
  Group g = upright(task);
  EXPECT_EQ(Numbers(g.observation.begin() + base, g.observation.begin() + constants),
            Numbers(26, 0.0));
  g.bodies[7] = 0.5;       // of the base along x
  g.bodies[12] = 0.4;      // about its z
  g.bodies[at(11)] = 2.0;  // of the pendulum about y
  step(task, g);
  const Numbers now(g.observation.begin(), g.observation.end());
  EXPECT_EQ(now[base], 0.5);
  EXPECT_NEAR(now[base + 3], 0.5 / world.dt, 1e-9);
  EXPECT_NEAR(now[base + 9], 0.2, 1e-15);  // z of the quaternion
  EXPECT_NEAR(now[base + 12], 0.4 / world.dt, 1e-9);
  EXPECT_NEAR(now[top], 2.0 * kCenter, 1e-15);
  EXPECT_NEAR(now[top + 3], 2.0 * kCenter / world.dt, 1e-9);
  EXPECT_NEAR(now[top + 8], 1.0, 1e-15);
  EXPECT_EQ(now[constants], 1.54);
  EXPECT_EQ(now[constants + 2], 0.0169101);
  EXPECT_EQ(now[constants + 4], 0.0125);
  EXPECT_EQ(now[constants + 5], 0.025);
}

TEST_F(PendulumTask, RewardsTheWayMadeAndUprightness) {
  const Instance task("pendulum", world);
  Group g = upright(task);
  const double before = kTop - 2.0;
  lean(g, 0.1);
  const double side = kCenter * std::sin(0.1), up = kJoint + kCenter * std::cos(0.1);
  const double after = std::hypot(side, kHeight + up - 2.0);
  step(task, g);
  // Sums of a few terms below 3.
  EXPECT_NEAR(g.reward[0], 2.0 * (before - after) + 0.01 + up / std::hypot(side, up), 1e-14);
  step(task, g);
  EXPECT_NEAR(g.reward[0], 0.01 + up / std::hypot(side, up), 1e-14) << "no way is made";
  EXPECT_EQ(g.end[0], 0u);
}

TEST_F(PendulumTask, ShapesTheRewardWhereTheScenarioAsksForIt) {
  const auto added = [&](const std::string& name, double far) {
    const auto reward = [&](double weight) {
      const Instance task("pendulum", world,
                          {{"target", Numbers{far, 0, kTop}},
                           {"bound", 20.0},
                           {name, weight},
                           {"privileged", false}});
      Group g = upright(task);
      step(task, g);
      return g.reward[0];
    };
    return reward(3.0) - reward(0.0);
  };
  // Differences of sums below 5.
  EXPECT_NEAR(added("approach_reward", 4.0), 3.0 * 0.6, 4e-15);
  EXPECT_NEAR(added("approach_reward", 12.0), 0.0, 4e-15) << "no reward is below 0";
  EXPECT_NEAR(added("precision_reward", 0.2), 1.5, 4e-15);
}

TEST_F(PendulumTask, EveryLimitEndsAnEpisodeUnderItsNameAndCostsFive) {
  const Instance task("pendulum", world, {{"yaw_max", 2.0}});
  const std::vector<std::string> names = channel_names(task.declared.task.infos);
  const auto fails = [&](const std::string& reason, const Numbers& base, double angle) {
    Group g = upright(task);
    for (int k = 0; k < 7; ++k)
      g.bodies[static_cast<std::size_t>(k)] = base[static_cast<std::size_t>(k)];
    for (int k = 0; k < 3; ++k) g.bodies[at(k)] = base[static_cast<std::size_t>(k)];
    g.bodies[at(2)] += kJoint;
    lean(g, angle);
    step(task, g);
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (names[k].rfind("failed.", 0) != 0) continue;
      EXPECT_EQ(g.info[k], names[k] == "failed." + reason ? 1.0 : 0.0) << names[k];
    }
    EXPECT_EQ(g.end[0], reason.empty() ? 0u : 1u) << reason;
    const double reward = g.reward[0];
    g.end[0] = 0;
    step(task, g);  // no progress
    EXPECT_NEAR(g.reward[0] - (reason.empty() ? 0.0 : -5.0), 0.01 + g.info[1], 1e-14) << reason;
    return reward;
  };
  const double c = std::cos(0.79), s = std::sin(0.79), y = std::cos(1.05), z = std::sin(1.05);
  fails("", {9.9, 0, 0.31, 1, 0, 0, 0}, 1.3);
  fails("bound", {10.1, 0, 2, 1, 0, 0, 0}, 0.0);
  fails("low", {0, 0, 0.29, 1, 0, 0, 0}, 0.0);
  fails("tilt", {0, 0, 2, c, s, 0, 0}, 0.0);
  fails("heading", {0, 0, 2, y, 0, 0, z}, 0.0);
  fails("fallen", {0, 0, 2, 1, 0, 0, 0}, 1.45);
}

TEST_F(PendulumTask, SucceedsNearTheTargetAloneAndNotWhereItFails) {
  const Instance task("pendulum", world, {{"target", Numbers{0, 0, kTop - 0.29}}});
  const std::size_t success = channel_names(task.declared.task.infos).size() - 1;
  Group g = upright(task);
  step(task, g);
  EXPECT_EQ(g.info[success], 1.0);
  EXPECT_NEAR(g.info[0], 0.29, 1e-14);
  g.bodies[at(1)] = 0.1;
  step(task, g);
  EXPECT_EQ(g.info[success], 0.0);
  g.bodies[at(1)] = 0.0;
  g.bodies[4] = 1.0;
  g.bodies[3] = 0.0;  // upside down
  step(task, g);
  EXPECT_EQ(g.info[success], 0.0);
}

TEST_F(PendulumTask, TheGoalPutsTheBobOnTheTarget) {
  const Instance task("pendulum", world);
  ASSERT_EQ(task.declared.task.goals.size(), 1u);
  EXPECT_EQ(task.declared.task.goals[0].body, bob);
  EXPECT_EQ(task.declared.task.goals[0].point.z, kCenter);
  Group g = upright(task);
  EXPECT_NEAR(task.goal(g)[2], 2.0 - kCenter, 1e-15);
}

TEST_F(PendulumTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("pendulum", world, {{"bob_link", "ball"}}),
              HasSubstr("has no link `ball`: there are base, bob"));
  EXPECT_THAT(refusal("pendulum", world, {{"bob_link", "base"}}),
              HasSubstr("name one that stands on a joint"));
  world.horizon = 9;
  EXPECT_THAT(refusal("pendulum", world, {}),
              HasSubstr("`history` is 10 steps, and an episode ends after 9: take fewer"));
  world.robots[0].action_count = 0;
  EXPECT_THAT(refusal("pendulum", world, {}), HasSubstr("give it a controller"));
}

}  // namespace
}  // namespace skybody::testing
