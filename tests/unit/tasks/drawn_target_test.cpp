// The task kit's drawn targets, in two tasks that use them unchanged: `obstacles` has a
// DrawnTarget, `hover` a DrawnPose.
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The EnvParam `target` after a reset.
Numbers target_after_reset(const Instance& task, Group& g, std::size_t count) {
  task.call(Call::kReset, g);
  const auto first = g.params.begin() + task.env_param("target");
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

/// The target of one episode.
Numbers target_of(const Instance& task, std::uint64_t key, std::uint64_t episode,
                  std::size_t count) {
  Group g = task.group(1);
  g.key.assign(g.key.size(), key);
  g.episode[0] = episode;
  return target_after_reset(task, g, count);
}

class DrawnTargetOfATask : public ::testing::Test {
 protected:
  DrawnTargetOfATask() {
    world.add_quad("quad");
    world.add_obstacle(SKYBODY_SPHERE, {0.5}, {0.0, 2.0, 1.0});
  }
  /// The refusal of a task whose flights end beyond 7 m and below 0.2 m.
  std::string refusal_of(const std::string& name, const Numbers& value) {
    return refusal("obstacles", world, {{name, value}, {"bound", 7.0}, {"height_min", 0.2}});
  }
  PluginWorld world;
  const Numbers low{-1.0, -2.0, 1.0}, high{-0.5, 2.0, 1.0};
  const Parameters box{{"target_min", low}, {"target_max", high}, {"nearest", 1}};
};

TEST_F(DrawnTargetOfATask, StaysWhereTheScenarioGivesIt) {
  const Instance task("obstacles", world, {{"target", Numbers{3.0, 1.0, 1.5}}, {"nearest", 1}});
  EXPECT_THAT(target_of(task, 7, 1, 3), ElementsAre(3.0, 1.0, 1.5));
  EXPECT_THAT(target_of(task, 8, 2, 3), ElementsAre(3.0, 1.0, 1.5));
  EXPECT_THAT(task.declared.writes, IsEmpty()) << "others may draw it";
}

TEST_F(DrawnTargetOfATask, IsDrawnAllOverItsBox) {
  const Instance task("obstacles", world, box);
  const int first = task.env_param("target");
  EXPECT_THAT(task.declared.writes, ElementsAre(first, first + 1, first + 2));
  Numbers least(3, 1e9), greatest(3, -1e9);
  for (std::uint64_t episode = 1; episode < 400; ++episode) {
    const Numbers target = target_of(task, 7, episode, 3);
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_GE(target[k], low[k]);
      ASSERT_LE(target[k], high[k]);
      least[k] = std::min(least[k], target[k]);
      greatest[k] = std::max(greatest[k], target[k]);
    }
  }
  // Probability that none of 399 uniform draws is in an outer twentieth: 1e-8.
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LE(least[k], low[k] + 0.05 * (high[k] - low[k]));
    EXPECT_GE(greatest[k], high[k] - 0.05 * (high[k] - low[k]));
  }
}

TEST_F(DrawnTargetOfATask, IsTheSameForTheSameSeedAndEpisode) {
  const Instance task("obstacles", world, box);
  EXPECT_EQ(target_of(task, 7, 3, 3), target_of(task, 7, 3, 3));
  EXPECT_NE(target_of(task, 7, 3, 3), target_of(task, 7, 4, 3));
  EXPECT_NE(target_of(task, 7, 3, 3), target_of(task, 8, 3, 3));
}

TEST_F(DrawnTargetOfATask, IsWhereACallerSetsIt) {
  const Instance task("obstacles", world, box);
  Group g = task.group(1);
  target_after_reset(task, g, 3);
  for (int k = 0; k < 3; ++k) g.at(g.params, task.env_param("target") + k) = 2.0 + k;
  task.call(Call::kEvaluate, g);
  const Numbers way(g.observation.begin(), g.observation.begin() + 3);
  EXPECT_THAT(way, ElementsAre(2.0 - g.bodies[0], 3.0 - g.bodies[1], 4.0 - g.bodies[2]));
}

TEST_F(DrawnTargetOfATask, IsRefusedWhereNoFlightCanReachIt) {
  EXPECT_THAT(refusal_of("target_min", {9.0, 0.0, 1.0}), HasSubstr("`target_min[0]` 9 is above"));
  EXPECT_THAT(refusal_of("target_max", {8.0, 2.0, 1.4}),
              HasSubstr("`target_max[0]` 8 lies beyond `bound` 7"));
  EXPECT_THAT(refusal_of("target_min", {5.5, -2.0, 0.1}),
              HasSubstr("`target_min[2]` 0.1 lies below `height_min` 0.2"));
  EXPECT_THAT(refusal_of("target", {0.0, -8.0, 1.0}),
              HasSubstr("`target[1]` -8 lies beyond `bound` 7"));
  EXPECT_THAT(refusal_of("target", {0.0, 0.0, 0.1}),
              HasSubstr("`target[2]` 0.1 lies below `height_min` 0.2"));
}

TEST_F(DrawnTargetOfATask, IsRefusedWithDrawnHeadingsBeside) {
  EXPECT_THAT(refusal("hover", world, {{"target", Numbers{1, 2, 1.5, 0.3}}, {"target_yaw", 0.4}}),
              HasSubstr("`target_yaw` says nothing beside `target`, which is not drawn"));
}

TEST_F(DrawnTargetOfATask, MayHaveAHeadingThatIsDrawnEitherWay) {
  const Instance task("hover", world, {{"target_yaw", 0.4}});
  const int first = task.env_param("target");
  EXPECT_THAT(task.declared.writes, ElementsAre(first, first + 1, first + 2, first + 3));
  double least = 0.0, greatest = 0.0;
  for (std::uint64_t episode = 1; episode < 400; ++episode) {
    const double yaw = target_of(task, 7, episode, 4)[3];
    ASSERT_LE(std::abs(yaw), 0.4);
    least = std::min(least, yaw);
    greatest = std::max(greatest, yaw);
  }
  EXPECT_LE(least, -0.36);
  EXPECT_GE(greatest, 0.36);
}

TEST_F(DrawnTargetOfATask, KeepsAGivenHeadingAndFollowsACallers) {
  const Instance task("hover", world, {{"target", Numbers{1.0, 2.0, 1.5, 0.3}}});
  Group g = task.group(1);
  EXPECT_THAT(target_after_reset(task, g, 4), ElementsAre(1.0, 2.0, 1.5, 0.3));
  EXPECT_THAT(task.goal(g), ElementsAre(1.0, 2.0, 1.5, 0.3));
  g.at(g.params, task.env_param("target") + 3) = -0.2;
  EXPECT_THAT(task.goal(g), ElementsAre(1.0, 2.0, 1.5, -0.2));
}

}  // namespace
}  // namespace skybody::testing
