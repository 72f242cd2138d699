// The task of a forest, by hand: visible obstacles, rewards, ends, goals of the baseline.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

/// Sums of a few numbers near 1: some roundings of 2e-16.
constexpr double kRounding = 1e-14;

class ObstaclesTask : public ::testing::Test {
 protected:
  ObstaclesTask() {
    world.add_quad("quad", 0, 0, 1);
    world.add_obstacle(SKYBODY_CYLINDER, {0.25, 4.0}, {3.0, 0.0, 1.0});
    sphere = world.add_obstacle(SKYBODY_SPHERE, {0.5}, {0.0, 2.0, 1.0});
    world.add_obstacle(SKYBODY_BOX, {1.0, 1.0, 2.0}, {0.0, -1.5, 1.0});
  }
  static Group begin(const Instance& task) {
    Group g = task.group(1);
    task.call(Call::kReset, g);
    task.call(Call::kEvaluate, g);
    return g;
  }
  /// One step later, at rest at a position.
  static void go(const Instance& task, Group& g, const Numbers& to) {
    for (std::size_t k = 0; k < 3; ++k) g.bodies[k] = to[k];
    ++g.step[0];
    g.end[0] = 0;
    task.call(Call::kEvaluate, g);
  }
  /// The k-th observed obstacle: offset, distance, size.
  static Numbers seen(const Group& g, int k) {
    const auto first = g.observation.begin() + 17 + 7 * k;
    return {first, first + 7};
  }
  static void expect_near(const Numbers& a, const Numbers& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], kRounding) << k;
  }
  PluginWorld world;
  const Parameters given{{"target", Numbers{6.0, 0.0, 1.0}}, {"nearest", 3}};
  int sphere = 0;
};

TEST_F(ObstaclesTask, GivesTheBitsOfDouble) {
  world.add_obstacle(SKYBODY_CAPSULE, {0.25, 1.0}, {0.5, 0.1, 0.0}, 0.4);
  world.add_obstacle(SKYBODY_GATE, {1.0, 0.8, 0.1}, {-0.5, 0.1, 0.0}, 0.4);
  world.add_obstacle(SKYBODY_PLANE, {}, {0.0, 0.0, -0.7});
  expect_same_bits("obstacles", world);
  expect_same_bits("obstacles", world, given);
}

TEST_F(ObstaclesTask, SeesTheNearestSurfacesInOrder) {
  const Instance task("obstacles", world, given);
  const Group g = begin(task);
  EXPECT_EQ(task.declared.channel_count(), 17 + 3 * 7);
  expect_near(seen(g, 0), {0.0, -1.0, 0.0, 1.0, 1.0, 1.0, 2.0});    // the box
  expect_near(seen(g, 1), {0.0, 1.5, 0.0, 1.5, 0.5, 0.0, 0.0});     // the sphere
  expect_near(seen(g, 2), {2.75, 0.0, 0.0, 2.75, 0.25, 4.0, 0.0});  // the cylinder
  EXPECT_NEAR(g.info[1], 0.8, kRounding) << "1 m less the radius";
}

TEST_F(ObstaclesTask, SeesNothingBeyondTheViewAndNothingThatIsNotThere) {
  Parameters near = given;
  near.insert({"view", 2.0});
  const Instance task("obstacles", world, near);
  Group g = begin(task);
  expect_near(seen(g, 2), {0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0});
  g.params[static_cast<std::size_t>(sphere + SKYBODY_OBSTACLE_PRESENT)] = 0.0;
  task.call(Call::kEvaluate, g);
  expect_near(seen(g, 1), {0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0});
}

TEST_F(ObstaclesTask, SeesWhereAndHowLargeObstaclesWereDrawn) {
  const Instance task("obstacles", world, given);
  Group g = begin(task);
  g.params[static_cast<std::size_t>(sphere + SKYBODY_OBSTACLE_POSITION + 1)] = 1.2;
  g.params[static_cast<std::size_t>(sphere + SKYBODY_OBSTACLE_SIZE)] = 0.4;
  task.call(Call::kEvaluate, g);
  expect_near(seen(g, 0), {0.0, 0.8, 0.0, 0.8, 0.4, 0.0, 0.0});
}

TEST_F(ObstaclesTask, FindsTheWayToCornersTopsAndOutOfSolids) {
  const Instance task("obstacles", world, given);
  Group g = begin(task);
  go(task, g, {0.8, -0.6, 2.2});  // beyond the box's corner by 0.3, 0.4 and 0.2
  expect_near(seen(g, 0), {-0.3, -0.4, -0.2, std::sqrt(0.29), 1.0, 1.0, 2.0});
  go(task, g, {3.0, 0.0, 3.5});  // above the cylinder
  expect_near(seen(g, 0), {0.0, 0.0, -0.5, 0.5, 0.25, 4.0, 0.0});
  go(task, g, {3.1, 0.0, 1.0});  // inside it
  expect_near(seen(g, 0), {0.15, 0.0, 0.0, -0.15, 0.25, 4.0, 0.0});
  go(task, g, {0.0, -1.1, 1.0});  // in the box, 0.1 m below a face
  expect_near(seen(g, 0), {0.0, 0.1, 0.0, -0.1, 1.0, 1.0, 2.0});
}

TEST_F(ObstaclesTask, RewardsProgressAndChargesForLackOfClearance) {
  const Instance task("obstacles", world, given);
  Group g = begin(task);
  EXPECT_EQ(g.reward[0], 0.0) << "no step, no progress, clear of everything";
  go(task, g, {0.5, 0.0, 1.0});
  EXPECT_NEAR(g.reward[0], 0.5, kRounding);
  go(task, g, {0.5, 1.2, 1.0});  // clear of the sphere by 0.94 - 0.5 - 0.2 m
  const double way = 5.5 - std::hypot(5.5, 1.2);
  const double lack = 1.0 - (std::hypot(0.5, 0.8) - 0.7) / 0.3;
  EXPECT_NEAR(g.reward[0], way - 0.1 * lack * lack, kRounding);
  g.bodies[10] = 2.0;
  task.call(Call::kEvaluate, g);
  EXPECT_NEAR(g.reward[0], -0.1 * lack * lack - 0.004, kRounding);
}

TEST_F(ObstaclesTask, EndsAtACollisionAtTheGroundAndAtTheTarget) {
  const Instance task("obstacles", world, given);
  const auto info = [&](const char* name, const Group& g) {
    const auto names = channel_names(task.declared.task.infos);
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    return g.info[static_cast<std::size_t>(at)];
  };
  Group g = begin(task);
  EXPECT_EQ(g.end[0], 0u);
  go(task, g, {2.6, 0.0, 1.0});
  EXPECT_EQ(g.end[0], 1u);
  EXPECT_EQ(info("failed.collision", g), 1.0);
  EXPECT_NEAR(g.reward[0], 2.6 - 0.1 - 5.0, kRounding);
  go(task, g, {5.0, 3.0, 0.05});
  EXPECT_EQ(g.end[0], 1u);
  EXPECT_EQ(info("failed.ground", g), 1.0);
  EXPECT_EQ(info("failed.collision", g), 0.0);
  go(task, g, {7.5, 3.0, 1.0});
  EXPECT_EQ(info("failed.bound", g), 1.0);
  go(task, g, {5.75, 0.0, 1.0});
  EXPECT_EQ(g.end[0], 1u);
  EXPECT_EQ(info("success", g), 1.0);
  EXPECT_NEAR(g.reward[0], std::hypot(1.5, 3.0) - 0.25 + 5.0, kRounding);
}

TEST_F(ObstaclesTask, LeadsTheBaselineAroundWhatIsAheadAndToTheTarget) {
  const Instance task("obstacles", world, given);
  Group g = begin(task);
  go(task, g, {2.0, 0.01, 1.0});  // the cylinder is ahead
  Numbers goal = task.goal(g);
  EXPECT_NEAR(std::hypot(goal[0] - 2.0, goal[1] - 0.01), 0.6, kRounding);
  EXPECT_GT(std::abs(goal[1] - 0.01), 0.2) << "past it";
  go(task, g, {4.5, 0.0, 1.0});  // nothing is ahead
  goal = task.goal(g);
  EXPECT_NEAR(goal[0], 5.1, kRounding);
  EXPECT_NEAR(goal[1], 0.0, kRounding);
  go(task, g, {5.6, 0.0, 1.0});
  EXPECT_EQ(task.goal(g), (Numbers{6.0, 0.0, 1.0, 0.0}));
}

TEST_F(ObstaclesTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("obstacles", world, {{"nearest", 4}}),
              HasSubstr("`nearest` is 4, and there are 3 obstacles: take no more than there are"));
  EXPECT_THAT(refusal("obstacles", world, {{"target_min", Numbers{7.0, 0.0, 1.0}}}),
              HasSubstr("`target_min[0]` 7 is above `target_max` 6.5: swap them"));
  EXPECT_THAT(
      refusal("obstacles", world, {{"target", Numbers{9.0, 0.0, 1.0}}, {"nearest", 3}}),
      HasSubstr("`target[0]` 9 lies beyond `bound` 7, where an episode ends: raise that, or "
                "bring it nearer"));
  world.add_obstacle(SKYBODY_HEIGHT_FIELD, {10.0, 10.0, 2.0}, {0.0, 0.0, 0.0});
  EXPECT_THAT(refusal("obstacles", world, given), HasSubstr("height field"));
  PluginWorld bare;
  bare.add_quad("quad");
  EXPECT_THAT(refusal("obstacles", bare, {}),
              HasSubstr("the scenario has no obstacles: add some, or take task `hover`"));
}

}  // namespace
}  // namespace skybody::testing
