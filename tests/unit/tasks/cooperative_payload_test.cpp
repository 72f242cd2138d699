// A shared load by hand: positions, observation, rewards, ends and refusals.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;

/// Arithmetic on coordinates of a few metres: some roundings of 2e-16.
constexpr double kRounding = 1e-14;

class CooperativePayloadTask : public ::testing::Test {
 protected:
  /// Two carriers, 1 m above a load at (0, 0, 1) and 0.6 m to its sides.
  CooperativePayloadTask() {
    world.add_quad("left", -0.6, 0.0, 2.0);
    world.add_quad("right", 0.6, 0.0, 2.0);
    add_load("plate");
  }
  void add_load(const std::string& name) {
    const int load = world.add_robot(name, 0.0, 0.0, 1.0);
    world.add_body(load, "plate", -1, SKYBODY_FREE, 1.2, {0.06, 0.06, 0.12});
    world.robots.back().action_count = 0;
    world.actions -= 4;
  }
  Group begin(const Instance& task) const {
    Group g = task.group(1);
    task.call(Call::kReset, g);
    return g;
  }
  static double& position(Group& g, int robot, int axis) {
    return g.bodies[static_cast<std::size_t>(13 * robot + axis)];
  }
  static void turn(Group& g, int robot, double angle, int axis) {
    const auto first = static_cast<std::size_t>(13 * robot + 3);
    g.bodies[first] = std::cos(0.5 * angle);
    g.bodies[first + static_cast<std::size_t>(axis)] = std::sin(0.5 * angle);
  }
  static void evaluate(const Instance& task, Group& g) {
    ++g.step[0];
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
  const Parameters fixed = {{"target", Numbers{0, 0, 1, 0}}};
  PluginWorld world;
};

TEST_F(CooperativePayloadTask, GivesTheBitsOfDouble) {
  expect_same_bits("cooperative_payload", world);
  expect_same_bits("cooperative_payload", world,
                   {{"tilt_cost", 0.5},
                    {"failure_reward", -3.0},
                    {"load_precision_reward", 2.0},
                    {"attachments", Numbers{-0.3, 0, 0.05, 0.3, 0, 0.05}}});
}

TEST_F(CooperativePayloadTask, GoalsAreThePlacesAboutTheLoadsTargetTurnedByItsYaw) {
  const double quarter = 0.5 * 3.141592653589793;
  const Instance task("cooperative_payload", world, {{"target", Numbers{1, 2, 3, quarter}}});
  Group g = begin(task);
  const Numbers expected = {1, 1.4, 4, 0, 1, 2.6, 4, 0};
  const Numbers goal = task.goal(g);
  ASSERT_EQ(goal.size(), expected.size());
  for (std::size_t k = 0; k < goal.size(); ++k) EXPECT_NEAR(goal[k], expected[k], kRounding);
}

TEST_F(CooperativePayloadTask, PlacesMayBeGiven) {
  const Instance task(
      "cooperative_payload", world,
      {{"target", Numbers{0, 0, 1, 0}}, {"places", Numbers{-1, 0, 0.5, 1, 0, 0.5}}});
  Group g = begin(task);
  const Numbers goal = task.goal(g);
  EXPECT_NEAR(goal[0], -1.0, kRounding);
  EXPECT_NEAR(goal[6], 1.5, kRounding);
}

TEST_F(CooperativePayloadTask, EveryCarrierObservesItselfTheLoadItsPointAndTheOther) {
  Parameters given = fixed;
  given.insert({"attachments", Numbers{-0.3, 0, 0.05, 0.3, 0, 0.05}});
  const Instance task("cooperative_payload", world, given);
  EXPECT_EQ(task.declared.channel_count(), 2 * 36);
  EXPECT_EQ(task.declared.channels[0].name, "left.place_error");
  EXPECT_EQ(task.declared.channels[9].name, "left.attachment");
  EXPECT_EQ(task.declared.channels[10].name, "left.right.offset");
  EXPECT_EQ(task.declared.channels[12].name, "right.place_error");
  Group g = begin(task);
  const double angle = 0.5 * 3.141592653589793;
  turn(g, 2, angle, 3);  // the load's points turn with it
  position(g, 2, 1) = 0.25;
  position(g, 0, 2) = 2.5;
  evaluate(task, g);
  const auto expect = [&](std::size_t first, const Numbers& values) {
    for (std::size_t k = 0; k < values.size(); ++k)
      EXPECT_NEAR(g.observation[first + k], values[k], kRounding) << first << " + " << k;
  };
  expect(0, {0, 0, -0.5});    // position error
  expect(13, {0, -0.25, 0});  // load's error
  expect(16, {-angle});       // and its yaw error
  expect(20, {std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle)});
  expect(27, {0.6, -0.05, -1.45});  // its point, now at (0, -0.05, 1.05)
  expect(30, {1.2, 0, -0.5});       // the other robot
}

TEST_F(CooperativePayloadTask, ACarriedLoadInItsPoseEarnsTheMost) {
  const Instance task("cooperative_payload", world, fixed);
  EXPECT_TRUE(task.declared.task.robot_rewards);
  Group g = begin(task);
  evaluate(task, g);
  EXPECT_NEAR(g.reward[0], 1.51, kRounding);  // load 1, position 0.5, rates 0.01
  EXPECT_NEAR(g.robot_reward[0], 1.51, kRounding);
  EXPECT_EQ(g.info.back(), 1.0);
  position(g, 0, 0) -= 1.0;  // one robot away from its position
  evaluate(task, g);
  EXPECT_NEAR(g.robot_reward[0], 1.01 + 0.5 / (1.0 + 2.56), kRounding);
  EXPECT_NEAR(g.robot_reward[1], 1.51, kRounding);
  EXPECT_NEAR(g.reward[0], 0.5 * (g.robot_reward[0] + g.robot_reward[1]), kRounding);
}

TEST_F(CooperativePayloadTask, EndsForEachReasonAndForNoOther) {
  struct Case {
    const char* reason;
    void (*put)(Group&);
  };
  const Case cases[] = {
      {"failed.tilt", [](Group& g) { turn(g, 1, 1.41, 1); }},
      {"failed.load_tilt", [](Group& g) { turn(g, 2, 1.01, 2); }},
      {"failed.bound", [](Group& g) { position(g, 0, 1) = 10.1; }},
      {"failed.bound", [](Group& g) { position(g, 2, 0) = -10.1; }},
      {"failed.separation", [](Group& g) { position(g, 0, 0) = 0.11; }},
      {"failed.dropped", [](Group& g) { position(g, 2, 2) = 0.29; }},
  };
  const Instance task("cooperative_payload", world, fixed);
  const std::vector<std::string> names = channel_names(task.declared.task.infos);
  Group g = begin(task);
  evaluate(task, g);
  EXPECT_EQ(g.end[0], 0u);
  for (const Case& c : cases) {
    g = begin(task);
    c.put(g);
    evaluate(task, g);
    EXPECT_EQ(g.end[0], 1u) << c.reason;
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (names[k].rfind("failed.", 0) == 0) {
        EXPECT_EQ(g.info[k], names[k] == c.reason ? 1.0 : 0.0) << c.reason << ", " << names[k];
      }
    }
    EXPECT_EQ(g.info.back(), 0.0) << "a moment that fails is no success";
  }
}

TEST_F(CooperativePayloadTask, SucceedsByPositionAndHeadingOfTheLoad) {
  const Instance task("cooperative_payload", world, fixed);
  const auto success = [&](double x, double yaw) {
    Group g = begin(task);
    position(g, 2, 0) = x;
    turn(g, 2, yaw, 3);
    evaluate(task, g);
    return g.info.back();
  };
  EXPECT_EQ(success(0.149, 0.19), 1.0);
  EXPECT_EQ(success(0.151, 0.0), 0.0);
  EXPECT_EQ(success(0.0, -0.21), 0.0);
}

TEST_F(CooperativePayloadTask, DrawsPosesWithinTheBox) {
  const Instance task("cooperative_payload", world,
                      {{"target_min", Numbers{1, 2, 3}}, {"target_max", Numbers{2, 3, 4}}});
  double least = 1.0, greatest = -1.0;
  for (std::uint64_t n = 1; n < 200; ++n) {
    Group g = task.group(1);
    g.episode[0] = n;
    task.call(Call::kReset, g);
    evaluate(task, g);
    for (std::size_t k = 0; k < 3; ++k) {
      const double target = g.observation[13 + k] + (k == 2 ? 1.0 : 0.0);  // the load is at z = 1
      ASSERT_GE(target, 1.0 + static_cast<double>(k));
      ASSERT_LE(target, 2.0 + static_cast<double>(k));
    }
    least = std::min(least, g.observation[16]);
    greatest = std::max(greatest, g.observation[16]);
  }
  EXPECT_LT(least, -0.3);
  EXPECT_GE(least, -0.4);
  EXPECT_GT(greatest, 0.3);
  EXPECT_LE(greatest, 0.4);
}

TEST_F(CooperativePayloadTask, BadConfigurationNamesValueAndRemedy) {
  const std::string task = "cooperative_payload";
  EXPECT_THAT(refusal(task, world, {{"target_min", Numbers{0, 3, 0}}}),
              HasSubstr("`target_min[1]` 3 is above `target_max` 1: swap them"));
  EXPECT_THAT(refusal(task, world, {{"places", Numbers{0, 0, 1}}}),
              HasSubstr("`places` has 3 values for 2 robots: write x, y, z for each"));
  EXPECT_THAT(refusal(task, world, {{"attachments", Numbers{0, 0, 1}}}),
              HasSubstr("`attachments` has 3 values for 2 robots"));
  EXPECT_THAT(refusal(task, world, {{"load", "left"}}),
              HasSubstr("the load `left` takes actions: name a robot without controllers"));
  EXPECT_THAT(refusal(task, world, {{"load", "crate"}}), HasSubstr("plate"));
  add_load("crate");
  EXPECT_THAT(refusal(task, world, {}),
              HasSubstr("`plate` and `crate` could both be the load: say which one by `load`"));
  PluginWorld alone;
  alone.add_quad("only");
  EXPECT_THAT(refusal(task, alone, {}), HasSubstr("there is no load"));
  const int load = alone.add_robot("plate", 0, 0, 1);
  alone.add_body(load, "plate", -1, SKYBODY_FREE, 1.2, {0.06, 0.06, 0.12});
  alone.robots.back().action_count = 0;
  EXPECT_THAT(refusal(task, alone, {}),
              HasSubstr("a load is carried by two robots or more, and 1 takes actions"));
}

}  // namespace
}  // namespace skybody::testing
