// Derivatives of the outputs of the shipped tasks: observations, rewards, info, targets.
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Inputs = std::set<std::string>;

void expect(const std::string& plugin, PluginWorld world, const Parameters& given,
            const Inputs& inputs) {
  expect_derivatives({plugin, world, given, Instance::Call::kEvaluate, {}}, inputs);
}

TEST(TaskDerivatives, OfHoverDependOnMotionTargetAndActions) {
  PluginWorld world;
  world.add_quad("quad");
  expect("hover", world, {}, {"action", "bodies", "buffer", "params"});
  expect("hover", world,
         {{"approach_reward", 1.0},
          {"precision_reward", 0.5},
          {"heading_reward", 0.25},
          {"tilt_cost", 0.1},
          {"failure_reward", -5.0}},
         {"action", "bodies", "buffer", "params"});
  world.add_quad("left", 0, 2, 1);
  expect("hover", world, {}, {"action", "bodies", "buffer", "params"});
}

TEST(TaskDerivatives, OfPayloadDependOnBothBodies) {
  PluginWorld world;
  world.add_quad("quad");
  world.add_payload("bob");
  expect("payload", world, {}, {"action", "bodies", "params"});
}

TEST(TaskDerivatives, OfReachDependOnTheVehicleTheArmAndThePlace) {
  PluginWorld world;
  world.add_quad("quad");
  world.add_arm_link("upper");
  world.add_arm_link("lower");
  world.links.back().position[2] = -0.2;
  expect("reach", world, {{"tool", "lower"}}, {"action", "bodies", "params", "q", "u"});
}

TEST(TaskDerivatives, OfFormationDependOnEachRobot) {
  PluginWorld world;
  world.add_quad("one");
  world.add_quad("two", 0, 2, 1);
  world.add_quad("three", 2, 0, 1);
  expect("formation", world, {}, {"bodies", "params"});
}

TEST(TaskDerivatives, OfObstaclesDependOnMotionPlacesAndSizes) {
  PluginWorld world;
  world.add_quad("quad");
  world.add_obstacle(SKYBODY_SPHERE, {0.3}, {1.5, 0.2, 1.0});
  world.add_obstacle(SKYBODY_CYLINDER, {0.2, 3.0}, {-1.0, 1.4, 0.5}, 0.3);
  world.add_obstacle(SKYBODY_BOX, {0.4, 0.5, 0.6}, {0.0, -1.8, 0.2}, 0.5);
  expect("obstacles", world, {{"nearest", 2}}, {"action", "bodies", "params", "state"});
}

TEST(TaskDerivatives, OfChaseDependOnAllRobots) {
  PluginWorld world;
  world.add_quad("hawk");
  world.add_quad("kite", 0, 2, 1);
  world.add_quad("evader", 2, 0, 1);
  expect("chase", world, {}, {"bodies", "buffer"});
}

}  // namespace
}  // namespace skybody::testing
