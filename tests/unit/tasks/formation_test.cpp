// Geometry, observation and rewards of the formation task, with robots at positions set by hand.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;
using Point = std::array<double, 3>;

/// Arithmetic on coordinates of a few metres: some roundings of 2e-16.
constexpr double kRounding = 1e-14;

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The corners of the README, implemented a second time.
std::vector<Point> polygon(int robots, double radius = 1.0) {
  std::vector<Point> places;
  if (robots >= 5) places.push_back({0.0, 0.0, 0.0});
  const int corners = robots >= 5 ? robots - 1 : robots;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * 3.141592653589793 * i / corners;
    places.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
  }
  return places;
}

double reward_of(double nearest, double error, double centroid_error, double heading) {
  const double s = std::clamp(std::pow(nearest / 0.5, 2), 0.0, 1.0);
  const double f = 1.0 / (1.0 + std::pow(1.6 * error, 2));
  const double g = std::exp(-centroid_error);
  return s * (f + f * (g + heading) + 0.4 * g);
}

class FormationTask : public ::testing::Test {
 protected:
  const Parameters fixed = {{"target", Numbers{0, 0, 2}}};

  /// Robots on the reference's diagonal.
  void add_team(int robots) {
    for (int i = 0; i < robots; ++i)
      world.add_quad("quad" + std::to_string(i + 1), 0.7 * i, 0.7 * i, 1.5);
  }
  Group begin(const Instance& task) const {
    Group g = task.group(1);
    task.call(Call::kReset, g);
    return g;
  }
  static void put(Group& g, int robot, const Point& p) {
    for (int k = 0; k < 3; ++k)
      g.bodies[static_cast<std::size_t>(13 * robot + k)] = p[static_cast<std::size_t>(k)];
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
  PluginWorld world;
};

TEST_F(FormationTask, GivesTheBitsOfDouble) {
  add_team(2);
  expect_same_bits("formation", world);
  for (const char* name : {"c", "d", "e"}) world.add_quad(name);
  expect_same_bits("formation", world,
                   {{"separation_min", 0.3}, {"tilt_max", 1.0}, {"distance_max", 2.0}});
}

TEST_F(FormationTask, ObservesEighteenValuesAndSixteenForEveryOther) {
  for (int robots = 1; robots <= 20; ++robots) {
    world.add_quad("quad" + std::to_string(robots), robots, 0, 1);
    if (robots < 2) continue;
    const Instance task("formation", world);
    ASSERT_EQ(task.declared.channel_count(), robots * (18 + 16 * (robots - 1)));
    Numbers own(static_cast<std::size_t>(robots), 0.0);
    for (std::size_t c = 0; c < task.declared.channels.size(); ++c)
      own.at(static_cast<std::size_t>(task.declared.channels[c].robot)) +=
          task.declared.channels[c].count;
    ASSERT_EQ(own, Numbers(static_cast<std::size_t>(robots), 18.0 + 16.0 * (robots - 1)));
  }
}

TEST_F(FormationTask, ObservesItselfThenTheOthersInOrder) {
  add_team(3);
  const Instance task("formation", world, fixed);
  EXPECT_EQ(task.declared.channels[0].name, "quad1.target_error");
  EXPECT_EQ(task.declared.channels[4].name, "quad1.quad2.offset");
  EXPECT_EQ(task.declared.channels[12].name, "quad2.target_error");
  EXPECT_EQ(task.declared.channels[16].name, "quad2.quad1.offset");
  Group g = begin(task);
  const double angle = 0.6;
  turn(g, 1, angle, 3);  // the second robot faces left
  for (std::size_t k = 0; k < 6; ++k) g.bodies[13 + 7 + k] = static_cast<double>(k + 1);
  evaluate(task, g);
  const double c = std::cos(angle), s = std::sin(angle);
  const Numbers rotation{c, -s, 0, s, c, 0, 0, 0, 1};
  Numbers self{-0.7, -0.7, 0.5, 1, 2, 3};  // target error, velocity, rotation row by row, rates
  self.insert(self.end(), rotation.begin(), rotation.end());
  self.insert(self.end(), {4, 5, 6});
  Numbers seen{0.7, 0.7, 0, 0.7 * std::sqrt(2.0), 1, 2, 3};  // by the first robot
  seen.insert(seen.end(), rotation.begin(), rotation.end());
  const auto expect = [&](std::size_t first, const Numbers& values) {
    for (std::size_t k = 0; k < values.size(); ++k)
      EXPECT_NEAR(g.observation[first + k], values[k], kRounding) << first << " + " << k;
  };
  expect(50, self);
  expect(18, seen);
  expect(50 + 18, {-0.7, -0.7, 0, 0.7 * std::sqrt(2.0), 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  expect(50 + 34, {0.7, 0.7, 0, 0.7 * std::sqrt(2.0), 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
}

TEST_F(FormationTask, PlacesAreARegularPolygonWithACentreFromFiveOn) {
  for (int robots = 1; robots <= 20; ++robots) {
    world.add_quad("quad" + std::to_string(robots), robots, 0, 1);
    if (robots < 2) continue;
    const Instance task("formation", world, {{"target", Numbers{1, -2, 3}}, {"radius", 1.5}});
    Group g = begin(task);
    const std::vector<Point> places = polygon(robots, 1.5);
    for (std::size_t i = 0; i < places.size();
         ++i) {  // robots at their positions have no way to go
      g.bodies[13 * i] = 1.0 + places[i][0];
      g.bodies[13 * i + 1] = -2.0 + places[i][1];
    }
    const Numbers goal = task.goal(g);
    ASSERT_EQ(goal.size(), 4u * static_cast<std::size_t>(robots));
    for (std::size_t i = 0; i < places.size(); ++i) {
      ASSERT_NEAR(goal[4 * i], 1.0 + places[i][0], kRounding) << robots << " robots";
      ASSERT_NEAR(goal[4 * i + 1], -2.0 + places[i][1], kRounding);
      ASSERT_EQ(goal[4 * i + 2], 3.0);
      ASSERT_EQ(goal[4 * i + 3], 0.0);
    }
  }
}

TEST_F(FormationTask, TheFinishedFormationEarnsTheMost) {
  add_team(5);
  const Instance task("formation", world, fixed);
  EXPECT_TRUE(task.declared.task.robot_rewards);
  Group g = begin(task);
  const std::vector<Point> places = polygon(5);
  for (int i = 0; i < 5; ++i) {
    const Point& p = places[static_cast<std::size_t>(i)];
    put(g, i, {p[0], p[1], 2.0 + p[2]});
  }
  evaluate(task, g);
  EXPECT_NEAR(g.reward[0], 3.4, kRounding);
  for (const double r : g.robot_reward) EXPECT_NEAR(r, 3.4, kRounding);
  EXPECT_NEAR(g.info[0], 0.0, kRounding);
  EXPECT_NEAR(g.info[1], 0.0, kRounding);
  EXPECT_NEAR(g.info[2], 1.0, kRounding);
  EXPECT_EQ(g.end[0], 0u);
}

TEST_F(FormationTask, TheTeamDoesNotMindWhoStandsWhereButTheRobotsDo) {
  add_team(2);
  const Instance task("formation", world, fixed);
  Group g = begin(task);
  put(g, 0, {-1, 0, 2});
  put(g, 1, {1, 0, 2});
  evaluate(task, g);
  EXPECT_NEAR(g.reward[0], 3.4, kRounding);
  for (const double r : g.robot_reward) EXPECT_NEAR(r, reward_of(2.0, 2.0, 0.0, 1.0), kRounding);
}

TEST_F(FormationTask, RewardsAsThePaperDoes) {
  add_team(3);
  const Instance task("formation", world, fixed);
  Group g = begin(task);
  const std::vector<Point> at = {{0.9, 0.1, 1.2}, {1.2, 0.3, 1.3}, {-0.4, -0.8, 1.7}};
  const Numbers heading = {std::cos(0.4), std::cos(-1.2), std::cos(0.9)};
  for (int i = 0; i < 3; ++i) put(g, i, at[static_cast<std::size_t>(i)]);
  turn(g, 0, 0.4, 3);  // yaw
  turn(g, 1, -1.2, 3);
  turn(g, 2, 0.9, 2);  // pitch reduces R00 as well
  evaluate(task, g);

  Point centroid{};
  for (const Point& p : at)
    for (std::size_t k = 0; k < 3; ++k) centroid[k] += p[k] / 3.0;
  const double centroid_error = distance(centroid, {0, 0, 2});
  std::vector<Point> places = polygon(3);
  for (Point& p : places)
    for (std::size_t k = 0; k < 3; ++k) p[k] += centroid[k];
  double hausdorff = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    double to_place = 1e9, to_robot = 1e9;
    for (std::size_t j = 0; j < 3; ++j) {
      to_place = std::min(to_place, distance(at[i], places[j]));
      to_robot = std::min(to_robot, distance(places[i], at[j]));
    }
    hausdorff = std::max({hausdorff, to_place, to_robot});
  }
  const double pair = distance(at[0], at[1]);  // nearer than half a metre
  ASSERT_LT(pair, 0.5);
  EXPECT_NEAR(g.info[0], hausdorff, kRounding);
  EXPECT_NEAR(g.info[1], centroid_error, kRounding);
  EXPECT_NEAR(g.info[2], pair, kRounding);
  const double mean = std::accumulate(heading.begin(), heading.end(), 0.0) / 3.0;
  EXPECT_NEAR(g.reward[0], reward_of(pair, hausdorff, centroid_error, mean), kRounding);
  const Numbers nearest = {pair, pair, std::min(distance(at[2], at[0]), distance(at[2], at[1]))};
  for (std::size_t i = 0; i < 3; ++i) {
    const double own = distance(at[i], places[i]);
    EXPECT_NEAR(g.robot_reward[i], reward_of(nearest[i], own, centroid_error, heading[i]),
                kRounding);
  }
}

TEST_F(FormationTask, SeesAnEmptyPlaceThatNoRobotIsFarFrom) {
  add_team(4);
  const Instance task("formation", world, fixed);
  Group g = begin(task);
  // Every robot is within 0.5 m of a position, yet the one at -y is empty.
  const std::vector<Point> at = {{0.9, 0, 2}, {0, 1.4, 2}, {-0.9, 0, 2}, {0, 0.7, 2}};
  for (int i = 0; i < 4; ++i) put(g, i, at[static_cast<std::size_t>(i)]);
  evaluate(task, g);
  const double mean_y = 2.1 / 4.0;
  EXPECT_NEAR(g.info[0], std::hypot(0.9, 1.0 - mean_y), kRounding);
}

TEST_F(FormationTask, GoalsLeadEachRobotAtAHeightOfItsOwnThatSinksNearItsPlace) {
  add_team(4);
  const Instance task("formation", world, {{"target", Numbers{0, 0, 3}}, {"radius", 1.0}});
  Group g = begin(task);
  const std::vector<Point> places = polygon(4, 1.0);
  const auto height = [&](std::size_t i, double away) {
    g.bodies[13 * i] = places[i][0] + away;
    g.bodies[13 * i + 1] = places[i][1];
    return task.goal(g)[4 * i + 2];
  };
  for (const std::size_t i : {0u, 1u, 3u}) {
    const double storeys = 0.5 * static_cast<double>(i);
    EXPECT_NEAR(height(i, 9.0), 3.0 + storeys, kRounding);
    EXPECT_NEAR(height(i, 1.25), 3.0 + 0.5 * storeys, 1e-12) << "half way between 2 m and 0.5 m";
    EXPECT_EQ(height(i, 0.4), 3.0);
  }
}

TEST_F(FormationTask, DrawsTargetsNearTheFirstRobotAndNotTooLow) {
  world.add_quad("first", 3, -4, 2);
  world.add_quad("second", 8, 8, 8);
  const Instance task("formation", world);
  int low = 0;
  for (std::uint64_t n = 1; n < 500; ++n) {
    Group g = task.group(1);
    g.episode[0] = n;
    task.call(Call::kReset, g);
    const Numbers goal = task.goal(g);  // of two robots; of the first one at its own height
    const double x = 0.5 * (goal[0] + goal[4]);
    ASSERT_LE(std::abs(x - 3.0), 2.0);
    ASSERT_LE(std::abs(goal[1] + 4.0), 2.0);
    ASSERT_GE(goal[2], 1.0);
    ASSERT_LE(goal[2], 1.5);
    low += goal[2] == 1.0 ? 1 : 0;
  }
  EXPECT_GT(low, 250);  // two thirds of [0, 1.5] lie below 1 m
  EXPECT_LT(low, 420);
}

TEST_F(FormationTask, DrawsTargetsInTheWorldWhereAskedTo) {
  add_team(2);
  const Instance task("formation", world,
                      {{"relative", false},
                       {"target_min", Numbers{-10, -10, -9}},
                       {"target_max", Numbers{10, 10, 11}}});
  double low = 0.0, highest = 0.0, farthest = 0.0;
  for (std::uint64_t n = 1; n <= 500; ++n) {
    Group g = task.group(1);
    g.episode[0] = n;
    task.call(Call::kReset, g);
    const Numbers goal = task.goal(g);
    low += goal[2] == 1.0 ? 1.0 : 0.0;
    highest = std::max(highest, goal[2]);
    farthest = std::max(farthest, std::abs(goal[1]));
  }
  EXPECT_NEAR(low / 500.0, 0.5, 0.1);  // four standard deviations
  EXPECT_GT(highest, 10.0);
  EXPECT_LE(highest, 11.0);
  EXPECT_GT(farthest, 9.0);
  EXPECT_LE(farthest, 10.0);
}

TEST_F(FormationTask, NothingEndsAnEpisodeUnlessAskedTo) {
  add_team(2);
  const auto ends = [&](const Parameters& given, const Point& second, double tilt) {
    Parameters all = fixed;
    all.insert(given.begin(), given.end());
    const Instance task("formation", world, all);
    Group g = begin(task);
    put(g, 0, {0, 0, 2});
    put(g, 1, second);
    turn(g, 1, tilt, 1);
    evaluate(task, g);
    return g.end[0];
  };
  EXPECT_EQ(ends({}, {0, 0, 2}, 0.0), 0u);
  EXPECT_EQ(ends({}, {1e4, 0, 2}, 3.14159265358979), 0u);
  EXPECT_EQ(ends({{"separation_min", 0.3}}, {0.31, 0, 2}, 0.0), 0u);
  EXPECT_EQ(ends({{"separation_min", 0.3}}, {0.29, 0, 2}, 0.0), 1u);
  EXPECT_EQ(ends({{"tilt_max", 1.57}}, {1, 0, 2}, -1.56), 0u);
  EXPECT_EQ(ends({{"tilt_max", 1.57}}, {1, 0, 2}, -1.58), 1u);
  EXPECT_EQ(ends({{"distance_max", 4.0}}, {0, 0, 5.9}, 0.0), 0u);
  EXPECT_EQ(ends({{"distance_max", 4.0}}, {0, 0, 6.1}, 0.0), 1u);
}

TEST_F(FormationTask, WithObstaclesGivesTheBitsOfDouble) {
  add_team(3);
  world.add_obstacle(SKYBODY_BOX, {0.4, 1.0, 0.6}, {1, 0, 1}, 0.7);
  world.add_obstacle(SKYBODY_CYLINDER, {0.2, 2.0}, {0, 1, 1});
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {-1, 0, 1});
  world.add_obstacle(SKYBODY_CAPSULE, {0.2, 0.8}, {0, -1, 1}, 0.3);
  expect_same_bits("formation", world,
                   {{"sees_place", true}, {"tilt_cost", 1.0}, {"failure_reward", -2.0}});
}

TEST_F(FormationTask, SeesTheWaysToTheNearestPointsOfObstaclesCutAtItsSight) {
  add_team(2);
  world.add_obstacle(SKYBODY_SPHERE, {1.0}, {0, 0, 12});
  world.add_obstacle(SKYBODY_CYLINDER, {0.5, 4.0}, {2, 0, 2});
  world.add_obstacle(SKYBODY_BOX, {1, 1, 1}, {0, 3, 2});
  Parameters given = fixed;
  given.insert({"obstacle_sight", 4.0});
  const Instance task("formation", world, given);
  ASSERT_EQ(task.declared.channel_count(), 2 * (34 + 3 * 4));
  EXPECT_EQ(task.declared.channels[8].name, "quad1.obstacle_1.offset");
  Group g = begin(task);
  put(g, 0, {0, 0, 2});
  put(g, 1, {-3, 0, 2});
  evaluate(task, g);
  const Numbers expected = {1.5, 0, 0, 1.5, 0, 2.5, 0, 2.5, 0, 0, 4, 4};
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_NEAR(g.observation[34 + k], expected[k], kRounding) << k;
  g.params[static_cast<std::size_t>(world.shapes[1].first_param)] = 0.0;  // the post is absent
  evaluate(task, g);
  EXPECT_NEAR(g.observation[34 + 3], 2.5, kRounding);  // the box is the nearest
  EXPECT_NEAR(g.observation[34 + 8], 0.0, kRounding);  // there is no third one
  EXPECT_NEAR(g.observation[34 + 11], 4.0, kRounding);
}

TEST_F(FormationTask, AnObstacleNearbyCostsRewardAndTouchingItEndsTheEpisode) {
  add_team(2);
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {1.75, 0, 2});
  const Instance task("formation", world, fixed);
  const std::vector<std::string> names = channel_names(task.declared.task.infos);
  const auto collision = static_cast<std::size_t>(
      std::find(names.begin(), names.end(), "failed.collision") - names.begin());
  ASSERT_LT(collision, names.size());
  Group g = begin(task);
  put(g, 0, {1, 0, 2});
  put(g, 1, {-1, 0, 2});
  evaluate(task, g);
  EXPECT_NEAR(g.reward[0], reward_of(0.25, 0.0, 0.0, 1.0), kRounding);
  EXPECT_NEAR(g.robot_reward[1], reward_of(2.0, 0.0, 0.0, 1.0), kRounding);
  EXPECT_EQ(g.end[0], 0u);
  EXPECT_EQ(g.info.back(), 1.0);
  g.contacts[6] = 1.0;  // the first robot has a contact
  evaluate(task, g);
  EXPECT_EQ(g.end[0], 1u);
  EXPECT_EQ(g.info[collision], 1.0);
  EXPECT_EQ(g.info.back(), 0.0);
}

TEST_F(FormationTask, OfManyObstaclesItSeesAsManyAsAskedFor) {
  add_team(2);
  for (int i = 0; i < 5; ++i) world.add_obstacle(SKYBODY_SPHERE, {0.1}, {i + 5.0, 0, 2});
  EXPECT_EQ(Instance("formation", world).declared.channel_count(), 2 * (34 + 3 * 4));
  EXPECT_EQ(Instance("formation", world, {{"obstacles_seen", 5}}).declared.channel_count(),
            2 * (34 + 5 * 4));
  EXPECT_EQ(Instance("formation", world, {{"obstacles_seen", 0}}).declared.channel_count(), 2 * 34);
}

TEST_F(FormationTask, ShowsEveryRobotItsPlaceWhereAskedTo) {
  add_team(2);
  Parameters given = fixed;
  given.insert({"sees_place", true});
  const Instance task("formation", world, given);
  Group g = begin(task);
  put(g, 1, {-1, 0.5, 2});
  evaluate(task, g);
  EXPECT_NEAR(g.observation[37 + 34], 0.0, kRounding);
  EXPECT_NEAR(g.observation[37 + 35], -0.5, kRounding);
}

TEST_F(FormationTask, BadConfigurationNamesValueAndRemedy) {
  add_team(1);
  EXPECT_THAT(refusal("formation", world, {}), HasSubstr("needs two robots or more"));
  world.add_quad("second");
  EXPECT_THAT(refusal("formation", world, {{"target_min", Numbers{0, 3, 0}}}),
              HasSubstr("`target_min[1]` 3 is above `target_max` 2"));
  PluginWorld hilly;
  for (const char* name : {"a", "b"}) hilly.add_quad(name);
  hilly.add_obstacle(SKYBODY_HEIGHT_FIELD, {4, 4}, {0, 0, 0}, 0.0, "hills");
  EXPECT_THAT(refusal("formation", hilly, {}),
              HasSubstr("obstacle `hills` is a height field, and task `formation` knows boxes"));
  world.robots[1].action_count = 0;
  EXPECT_THAT(refusal("formation", world, {}),
              HasSubstr("robot `second` takes no action, so that it cannot fly to its place"));
}

}  // namespace
}  // namespace skybody::testing
