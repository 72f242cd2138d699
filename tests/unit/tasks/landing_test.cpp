// The landing on a deck, by hand.
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

/// A quad whose feet are 0.06 m below its frame, over a deck of 1.2 m whose face is at 0.53 m.
class LandingTask : public ::testing::Test {
 protected:
  LandingTask() {
    world.add_quad("quad", 0, 0, 2);
    pad = world.add_robot("pad", 0, 0, 0.5);
    world.add_body(pad, "deck", -1, SKYBODY_FREE, 20.0, {2.4, 2.4, 4.8});
    world.robots[1].action_count = 0;
    world.actions = 4;
    world.add_shape(0, SKYBODY_BOX, {0.3, 0.35, 0.05}, 0.005);
    world.add_shape(0, SKYBODY_SPHERE, {0.01}, -0.05);
    world.add_shape(1, SKYBODY_BOX, {1.2, 1.2, 0.06});
  }
  Group begin(const Instance& task, const Numbers& at = {0, 0, 2}) const {
    Group g = task.group(1);
    put(g, at);
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  static void put(Group& g, const Numbers& p) {
    for (std::size_t k = 0; k < 3; ++k) g.bodies[k] = p[k];
  }
  static void turn(Group& g, std::size_t body, double angle, std::size_t axis) {
    g.bodies[13 * body + 3] = std::cos(0.5 * angle);
    g.bodies[13 * body + 3 + axis] = std::sin(0.5 * angle);
  }
  static void step(const Instance& task, Group& g) {
    ++g.step[0];
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
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
  int pad = 0;
};

TEST_F(LandingTask, GivesTheBitsOfDouble) {
  expect_same_bits("landing", world, {{"time_max", 0.02}, {"touch_height", 0.5}});
}

TEST_F(LandingTask, ObservesTheDeckFromTheRobot) {
  const Instance task("landing", world);
  EXPECT_EQ(task.declared.channel_count(), 18);
  Group g = begin(task);
  turn(g, 1, 0.5 * kPi, 3);  // the deck faces y
  g.bodies[13 + 7] = 1.0;    // and moves along x
  put(g, {0.3, 0.1, 2});
  for (std::size_t k = 0; k < 3; ++k) g.bodies[10 + k] = static_cast<double>(k + 1);
  g.action = {0.1, 0.2, 0.3, 0.4};
  step(task, g);
  const double h = std::sqrt(0.5);
  const Numbers expected{
      -0.1, 0.3, -(2 - 0.06 - 0.53), 0, 1, 0, 0.5 * kPi, h, 0, 0, -h, 1, 2, 3, 0.1, 0.2, 0.3, 0.4};
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_NEAR(g.observation[k], expected[k], kRounding) << k;
}

TEST_F(LandingTask, SeesTheVelocityOfATurningDeckWhereItIs) {
  const Instance task("landing", world);
  Group g = begin(task, {0.5, 0, 1});
  g.bodies[13 + 12] = 2.0;  // about z
  step(task, g);
  EXPECT_NEAR(g.observation[4], -1.0, kRounding);
}

TEST_F(LandingTask, HasLandedSlowLevelAndWithinTheEdges) {
  const Instance task("landing", world, {{"tilt_max", kPi}});
  const auto ends = [&](double x, double z, double speed, double tilt) {
    Group g = begin(task, {x, 0, z});
    g.bodies[9] = -speed;
    turn(g, 0, tilt, 2);
    step(task, g);
    EXPECT_EQ(g.end[0] == 1u, info(task, g, "success") == 1.0) << "success ends the episode";
    return g.end[0];
  };
  const double down = 0.53 + 0.06;
  EXPECT_EQ(ends(0.0, down, 0.0, 0.0), 1u);
  EXPECT_EQ(ends(0.49, down, 0.19, 0.0), 1u);
  EXPECT_EQ(ends(0.51, down, 0.0, 0.0), 0u) << "within 0.1 m of the edge";
  EXPECT_EQ(ends(0.0, down + 0.006, 0.0, 0.0), 0u) << "6 mm above the deck";
  EXPECT_EQ(ends(0.0, down, 0.21, 0.0), 0u) << "still moves";
  EXPECT_EQ(ends(0.0, down, 0.0, 0.25), 0u) << "tilted";
}

TEST_F(LandingTask, PaysForTheWayAndTheLandingAndTakesHasteOff) {
  const Instance task("landing", world);
  Group g = begin(task, {0, 0, 1.59});
  put(g, {0, 0, 1.39});
  step(task, g);
  EXPECT_NEAR(g.reward[0], 5.0 * 0.2, kRounding) << "0.2 m nearer";
  g.bodies[7] = 2.0;  // 0.2 m/s and 0.8 m/s are free of cost
  g.bodies[10] = 3.0;
  step(task, g);
  EXPECT_NEAR(g.reward[0], -0.05 * (2.0 - 1.0) - 0.001 * 9.0, kRounding);
  g.bodies[7] = g.bodies[10] = 0.0;
  step(task, g);
  put(g, {0, 0, 0.59});
  step(task, g);
  EXPECT_NEAR(g.reward[0], 5.0 * 0.8 + 20.0, kRounding);
}

TEST_F(LandingTask, CrashesWhereItCameTooFastOrTilted) {
  const Instance task("landing", world, {{"tilt_max", kPi}});
  const auto crash = [&](double speed_before, double speed, double tilt) {
    Group g = begin(task, {0, 0, 0.7});
    g.bodies[9] = -speed_before;
    step(task, g);
    EXPECT_EQ(g.end[0], 0u);
    put(g, {0, 0, 0.53 + 0.06});
    g.bodies[9] = -speed;
    turn(g, 0, tilt, 2);
    step(task, g);
    const bool crashed = info(task, g, "failed.crash") == 1.0;
    EXPECT_EQ(g.end[0] == 1u, crashed || info(task, g, "success") == 1.0);
    EXPECT_FALSE(crashed && info(task, g, "success") == 1.0) << "a crash is no success";
    return crashed;
  };
  EXPECT_FALSE(crash(0.9, 0.9, 0.0));
  EXPECT_TRUE(crash(1.1, 0.0, 0.0)) << "contact has stopped it already";
  EXPECT_FALSE(crash(0.9, 0.0, 0.4));
  EXPECT_TRUE(crash(0.1, 0.0, 0.6));
}

TEST_F(LandingTask, FailsOutsideOrLateAndByTheLimitsOfFlight) {
  const Instance task("landing", world, {{"time_max", 0.002}});
  const auto reason = [&](const Numbers& p, int steps) {
    Group g = begin(task, p);
    for (int k = 0; k < steps; ++k) step(task, g);
    std::string found;
    for (const char* name : {"bound", "crash", "outside", "time"})
      if (info(task, g, std::string("failed.") + name) == 1.0) found += name;
    if (info(task, g, "success") == 1.0) found += "success";
    EXPECT_EQ(g.end[0], found.empty() ? 0u : 1u);
    return found;
  };
  EXPECT_EQ(reason({0, 0, 2}, 1), "");
  EXPECT_EQ(reason({0, 0, 2}, 2), "time");
  EXPECT_EQ(reason({4, 4, 2}, 1), "outside");
  EXPECT_EQ(reason({0.8, 0, 0.5}, 1), "outside") << "below the deck's face";
  EXPECT_EQ(reason({0, 0, 7.5}, 1), "boundoutside");
  EXPECT_EQ(reason({0, 0, 0.59}, 2), "success") << "it is down in time";
}

TEST_F(LandingTask, LeadsTheBaselineOverTheDeckAndThenDown) {
  const Instance task("landing", world, {{"descent", 0.5}});
  Group g = begin(task, {0.1, 0, 1.0});
  g.bodies[13 + 7] = 0.2;
  Numbers goal = task.goal(g), motion = task.goal_motion(g);
  EXPECT_NEAR(goal[0], 0.0, kRounding);
  EXPECT_NEAR(goal[2], 1.0, kRounding);
  EXPECT_NEAR(motion[0], 0.2, kRounding) << "with the deck";
  EXPECT_NEAR(motion[2], -0.5, kRounding);
  g = begin(task, {1.25, 0, 1.0});  // goal 2 m above the deck, less the room of 0.3 m
  goal = task.goal(g);
  EXPECT_NEAR(goal[2], 1.0 + 2.0 - 0.3 - (1.0 - 0.59), kRounding);
  EXPECT_EQ(task.goal_motion(g)[2], 0.0);
}

TEST_F(LandingTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("landing", world, {{"pad", "pda"}}),
              HasSubstr("no robot `pda`: there are quad, pad"));
  EXPECT_THAT(refusal("landing", world, {{"robot", "pad"}}),
              HasSubstr("`robot` and `pad` are both `pad`"));
  EXPECT_THAT(refusal("landing", world, {{"rest_speed", 2.0}}),
              HasSubstr("`rest_speed` 2 is above `crash_speed` 1: swap them"));
  EXPECT_THAT(refusal("landing", world, {{"rest_tilt", 1.0}}),
              HasSubstr("`rest_tilt` 1 is above `crash_tilt` 0.5"));
  EXPECT_THAT(refusal("landing", world, {{"inset", 0.7}}),
              HasSubstr("`inset` 0.7 leaves nothing of the deck; allowed: less than 0.6"));
  world.shapes.back().kind = SKYBODY_SPHERE;
  EXPECT_THAT(refusal("landing", world, {}),
              HasSubstr("the base of robot `pad` has no box to land on"));
  world.shapes.clear();
  EXPECT_THAT(refusal("landing", world, {}),
              HasSubstr("the base of robot `quad` has no collision shape"));
  world.robots[0].action_count = 0;
  EXPECT_THAT(refusal("landing", world, {}), HasSubstr("no robot but the pad takes actions"));
}

}  // namespace
}  // namespace skybody::testing
