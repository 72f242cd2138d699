// Observation, reward and ends of the task `trajectory` by hand.
#include <cmath>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;

/// A constant reference at (1, 2, 1.5), so that its values are known by hand.
Parameters holding(const Parameters& more = {}) {
  Parameters given = {{"kind", "hold"}, {"centre", Numbers{1.0, 2.0, 1.5}}};
  for (const auto& [name, value] : more) given.insert_or_assign(name, value);
  return given;
}
/// A level circle of 1 m about (0, 0, 1), at 1 m/s from the start: r = (cos t, sin t, 1).
Parameters circling(const Parameters& more = {}) {
  Parameters given = {{"kind", "circle"},
                      {"centre", Numbers{0.0, 0.0, 1.0}},
                      {"amplitude", Numbers{1.0, 1.0, 0.0}},
                      {"period", 2.0 * 3.14159265358979323846},
                      {"ramp", 0.0},
                      {"check", false},
                      {"yaw", "tangent"}};
  for (const auto& [name, value] : more) given.insert_or_assign(name, value);
  return given;
}
const Parameters kCompact = {{"history", 1}, {"window", 2}, {"spacing", 0.1}, {"matrices", false}};

class TrajectoryTask : public ::testing::Test {
 protected:
  TrajectoryTask() { world.add_quad("quad"); }

  Group begin(const Instance& task) const {
    Group g = task.group(1);
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  /// A step that leaves the robot at the position set by the test.
  static void step(const Instance& task, Group& g, const Numbers& action, int physics_steps = 1) {
    g.action = action;
    ++g.step[0];
    g.physics_step[0] += static_cast<std::uint64_t>(physics_steps);
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
  static void place(Group& g, const Numbers& position, const Numbers& velocity = {0, 0, 0}) {
    for (std::size_t k = 0; k < 3; ++k) {
      g.bodies[k] = position[k];
      g.bodies[7 + k] = velocity[k];
    }
  }
  /// Rotated by an angle [rad] about a body axis: 0, 1, 2.
  static void turn(Group& g, std::size_t axis, double angle) {
    for (std::size_t k = 0; k < 4; ++k) g.bodies[3 + k] = 0.0;
    g.bodies[3] = std::cos(0.5 * angle);
    g.bodies[4 + axis] = std::sin(0.5 * angle);
  }
  /// Values of a channel.
  static Numbers seen(const Instance& task, const Group& g, const std::string& name) {
    std::ptrdiff_t first = 0;
    for (const Channel& c : task.declared.channels) {
      const auto from = g.observation.begin() + first;
      if (c.name == name) return {from, from + c.count};
      first += c.count;
    }
    ADD_FAILURE() << "no channel " << name;
    return {};
  }
  static double info(const Instance& task, const Group& g, const std::string& name) {
    const std::vector<std::string> names = channel_names(task.declared.task.infos);
    const auto found = std::find(names.begin(), names.end(), name);
    return g.info.at(static_cast<std::size_t>(found - names.begin()));
  }
  PluginWorld world;
};

void expect_near(const Numbers& got, const Numbers& expected, double tolerance) {
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t k = 0; k < got.size(); ++k) EXPECT_NEAR(got[k], expected[k], tolerance) << k;
}

TEST_F(TrajectoryTask, GivesTheBitsOfDouble) {
  expect_same_bits("trajectory", world, circling({{"approach", 0.02}, {"ramp", 0.01}}));
  Parameters compact = circling(kCompact);
  compact.insert_or_assign("axes", "body");
  expect_same_bits("trajectory", world, compact);
}

TEST_F(TrajectoryTask, HasThePapersDimensions) {
  EXPECT_EQ(Instance("trajectory", world, holding()).declared.channel_count(), 700);
  EXPECT_EQ(Instance("trajectory", world, holding({{"matrices", false}})).declared.channel_count(),
            11 * 20 + 6 * 20 + 5);
  EXPECT_EQ(Instance("trajectory", world, holding(kCompact)).declared.channel_count(),
            11 + 6 * 2 + 5);
  world.robots[0].action_count = 3;
  EXPECT_EQ(Instance("trajectory", world, holding()).declared.channel_count(), 680);
}

TEST_F(TrajectoryTask, RemembersTheNewestFirstAndAtAResetTheBeginning) {
  Parameters given = holding({{"history", 3}});
  const Instance task("trajectory", world, given);
  Group g = begin(task);
  EXPECT_EQ(seen(task, g, "height"), (Numbers{1, 1, 1}));
  EXPECT_EQ(seen(task, g, "actions"), Numbers(12, -1.0));
  place(g, {0, 0, 2}, {1, 2, 3});
  step(task, g, {0.1, 0.2, 0.3, 0.4});
  place(g, {0, 0, 3}, {4, 5, 6});
  step(task, g, {0.5, 0.6, 0.7, 0.8});
  EXPECT_EQ(seen(task, g, "height"), (Numbers{3, 2, 1}));
  EXPECT_EQ(seen(task, g, "velocity"), (Numbers{4, 5, 6, 1, 2, 3, 0, 0, 0}));
  EXPECT_EQ(seen(task, g, "actions"),
            (Numbers{0.5, 0.6, 0.7, 0.8, 0.1, 0.2, 0.3, 0.4, -1, -1, -1, -1}));
}

TEST_F(TrajectoryTask, LooksAheadAlongThePathFromWhereItIsNow) {
  const Instance task("trajectory", world, circling({{"window", 2}, {"spacing", 0.5}}));
  Group g = begin(task);
  place(g, {0.5, 0.0, 1.0}, {0.0, 0.25, 0.0});
  step(task, g, {0, 0, 0, 0}, 250);
  const double a = 0.25, b = 0.75;
  expect_near(seen(task, g, "position_error"),
              {std::cos(a) - 0.5, std::sin(a), 0, std::cos(b) - 0.5, std::sin(b), 0}, 1e-14);
  expect_near(seen(task, g, "velocity_error"),
              {-std::sin(a), std::cos(a) - 0.25, 0, -std::sin(b), std::cos(b) - 0.25, 0}, 1e-14);
}

TEST_F(TrajectoryTask, KnowsTheAttitudeThatFliesThePath) {
  const Instance task("trajectory", world, circling({{"window", 1}}));
  Group g = begin(task);
  const Numbers r = seen(task, g, "reference_attitude");
  // At t = 0 the vehicle accelerates towards the centre, -x, and faces +y.
  const double size = std::hypot(1.0, 9.81);
  expect_near({r[2], r[5], r[8]}, {-1.0 / size, 0.0, 9.81 / size}, 1e-14);
  EXPECT_NEAR(std::atan2(r[3], r[0]), 1.5707963267948966, 0.01) << "leans as it turns";
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(std::hypot(r[3 * i], r[3 * i + 1], r[3 * i + 2]), 1.0, 1e-14) << i;
  }
}

TEST_F(TrajectoryTask, CompactVectorsTurnWithTheBody) {
  Parameters given = holding(kCompact);
  given.insert_or_assign("axes", "body");
  const Instance task("trajectory", world, given);
  Group g = begin(task);
  place(g, {0, 2, 1.5}, {3, 0, 0});
  turn(g, 2, 1.5707963267948966);  // faces y: W's x is B's -y
  step(task, g, {0, 0, 0, 0});
  expect_near(seen(task, g, "position_error"), {0, -1, 0, 0, -1, 0}, 1e-15);
  expect_near(seen(task, g, "velocity"), {0, -3, 0}, 1e-15);
  expect_near(seen(task, g, "up"), {0, 0, 1}, 1e-15);
  expect_near(seen(task, g, "yaw_error"), {-1.5707963267948966}, 1e-15);
}

TEST_F(TrajectoryTask, CompactAttitudesInTheWorldsAxesKeepTheirSign) {
  const Instance task("trajectory", world, holding(kCompact));
  Group g = begin(task);
  turn(g, 0, 6.0);  // cos 3 < 0
  step(task, g, {0, 0, 0, 0});
  expect_near(seen(task, g, "attitude"), {-std::cos(3.0), -std::sin(3.0), 0, 0}, 1e-15);
}

TEST_F(TrajectoryTask, RewardsAsThePaperDoes) {
  const Instance task("trajectory", world, holding());
  Group g = begin(task);
  place(g, {1.3, 1.6, 1.7}, {1, -2, 3});
  g.bodies[10] = 2.0;
  step(task, g, {0.5, -0.5, 1.0, 0.0});
  const double cost = 0.1 * (0.09 + 0.16) + 2 * 0.04 + 0.002 * 5 + 0.04 * 9 + 0.01 * 4 + 0.01 * 1.5;
  EXPECT_NEAR(g.reward[0], 1.0 / (1.0 + cost), 1e-15);
  EXPECT_EQ(g.end[0], 0u);
}

TEST_F(TrajectoryTask, AddsToTheRewardWhatTheScenarioAsksFor) {
  const auto reward = [&](const Parameters& more) {
    const Instance task("trajectory", world, holding(more));
    Group g = begin(task);
    place(g, {1.2, 2.0, 1.5});
    turn(g, 2, 0.5);
    step(task, g, {0, 0, 0, 0});
    return g.reward[0];
  };
  EXPECT_NEAR(reward({{"precision_reward", 3.0}}) - reward({}), 1.5, 1e-14);
  EXPECT_NEAR(reward({{"heading_reward", 3.0}}) - reward({}), 1.5, 1e-14);
}

TEST_F(TrajectoryTask, EndsBeyondEachLimitAndSaysWhich) {
  const Instance task("trajectory", world, holding({{"failure_reward", -7.0}}));
  const auto end = [&](const std::string& reason, const Numbers& position, double angle,
                       double rate) {
    Group g = begin(task);
    place(g, position);
    turn(g, 0, angle);
    g.bodies[12] = rate;
    step(task, g, {0, 0, 0, 0});
    double reasons = 0.0;
    for (const char* name : {"failed.side", "failed.height", "failed.tilt", "failed.rate"}) {
      reasons += info(task, g, name);
    }
    if (reason.empty()) {
      EXPECT_EQ(reasons, 0.0);
      EXPECT_GT(g.reward[0], 0.0);
    } else {
      EXPECT_EQ(reasons, 1.0) << reason;
      EXPECT_EQ(info(task, g, "failed." + reason), 1.0) << reason;
      EXPECT_EQ(g.reward[0], -7.0);
    }
    return g.end[0];
  };
  const double degree = 3.14159265358979323846 / 180.0;
  EXPECT_EQ(end("", {8.9, -8.9, 9.9}, 157.0 * degree, 9.9), 0u);
  EXPECT_EQ(end("side", {9.1, 0, 1}, 0, 0), 1u);
  EXPECT_EQ(end("side", {0, -9.1, 1}, 0, 0), 1u);
  EXPECT_EQ(end("height", {0, 0, 10.1}, 0, 0), 1u);
  EXPECT_EQ(end("height", {0, 0, 0.09}, 0, 0), 1u);
  EXPECT_EQ(end("tilt", {0, 0, 1}, 158.0 * degree, 0), 1u);
  EXPECT_EQ(end("rate", {0, 0, 1}, 0, -10.1), 1u);
}

TEST_F(TrajectoryTask, SucceedsByTheMeanErrorSinceItHasSettled) {
  const Instance task("trajectory", world, holding({{"settle", 0.0025}}));
  Group g = begin(task);
  place(g, {1, 2, 5});
  step(task, g, {0, 0, 0, 0});
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(info(task, g, "mean_error"), 3.5, 1e-14) << "of now";
  EXPECT_EQ(info(task, g, "success"), 0.0);
  place(g, {1, 2, 1.52});
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(info(task, g, "mean_error"), 0.02, 1e-14);
  EXPECT_EQ(info(task, g, "success"), 1.0);
  place(g, {1, 2, 1.7});
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(info(task, g, "position_error"), 0.2, 1e-14);
  EXPECT_NEAR(info(task, g, "mean_error"), 0.11, 1e-14);
  EXPECT_EQ(info(task, g, "success"), 0.0);
  place(g, {1, 2, 1.5});
  g.bodies[12] = 20.0;
  step(task, g, {0, 0, 0, 0});
  EXPECT_NEAR(info(task, g, "mean_error"), 0.22 / 3.0, 1e-14);
  EXPECT_EQ(info(task, g, "success"), 0.0) << "a moment that fails is none";
}

TEST_F(TrajectoryTask, AWayOntoThePathBeginsWhereTheRobotIs) {
  const Instance task("trajectory", world, circling({{"approach", 2.0}}));
  Group g = begin(task);
  expect_near(task.goal(g), {0, 0, 1, 1.5707963267948966}, 1e-15);
  g.physics_step[0] = 2000;
  expect_near(task.goal(g), {1, 0, 1, 1.5707963267948966}, 1e-15);
}

TEST_F(TrajectoryTask, DerivativesDependOnMotionPathAndActions) {
  // No value vanishes by symmetry, because its differences would be rounding only.
  const Parameters figure = {{"kind", "lissajous"},
                             {"centre", Numbers{0.3, -0.2, 1.1}},
                             {"amplitude", Numbers{1.1, 0.9, 0.3}},
                             {"cycles", Numbers{1.0, 2.0, 1.5}},
                             {"phase", Numbers{1.4, 0.2, 0.3}},
                             {"yaw", "tangent"},
                             {"history", 3},
                             {"window", 3},
                             {"spacing", 0.05},
                             {"precision_reward", 1.0},
                             {"heading_reward", 0.5}};
  expect_derivatives({"trajectory", world, figure, Call::kEvaluate, {}},
                     {"action", "bodies", "buffer", "params", "state"});
}

TEST_F(TrajectoryTask, BadConfigurationNamesValueAndRemedy) {
  const auto refused = [&](const Parameters& given) { return refusal("trajectory", world, given); };
  EXPECT_THAT(refused(holding({{"height_min", 12.0}})),
              HasSubstr("`height_min` 12 is not below `height_max` 10"));
  EXPECT_THAT(refused(holding({{"centre", Numbers{10, 0, 1}}})),
              HasSubstr("the path leads to x = 10 m after 0 s, and beyond 9 m an episode has "
                        "failed: move the path"));
  EXPECT_THAT(refused(circling({{"centre", Numbers{0, 0, 0}}})), HasSubstr("z = 0 m"));
  EXPECT_THAT(refused(circling({{"amplitude", Numbers{0, 0, 0}}})),
              HasSubstr("the path has no length"));
  EXPECT_THAT(refused(circling({{"period", 0.5}, {"ramp", 2.0}, {"check", true}})),
              HasSubstr("time_scale"));
  EXPECT_EQ(refused(circling({{"period", 0.5}, {"ramp", 2.0}})), "");
  EXPECT_THAT(refused({{"kind", "csv"}}), HasSubstr("needs `file`"));
  world.horizon = 10;
  EXPECT_THAT(refused(holding({{"window", 1}})),
              HasSubstr("`history` is 20 steps, and an episode ends after 10: take fewer"));
  EXPECT_THAT(refused(holding({{"history", 1}})),
              HasSubstr("`window` and `spacing` look ahead by 0.19 s, and an episode ends after "
                        "0.01 s: look less far"));
  world.robots[0].action_count = 0;
  EXPECT_THAT(refused(holding()), HasSubstr("give it a controller"));
}

}  // namespace
}  // namespace skybody::testing
