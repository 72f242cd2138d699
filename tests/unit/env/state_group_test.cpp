// StateGroup: bodies and stepper follow every kind of write.
#include "core/env/state_group.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// A quadrotor in each of 32 lanes at a height of 1 m.
class StateGroupTest : public testing::Test {
 protected:
  StateGroupTest() : compiled_(scenario(), factory_), flight_(compiled_, kGroupLanes) {
    flight_.reset();
  }

  StateGroup& group() { return flight_.group; }
  PhysicsScratch& scratch() { return flight_.work->physics; }
  const StateLayout& layout() const { return compiled_.layout(); }
  /// Vertical velocity after one step of free fall.
  double fall(int lane) {
    group().advance(1u << lane, scratch());
    return group().reals(layout().u)[2 * kGroupLanes + lane];
  }

  InProcessFactory factory_;
  CompiledScenario compiled_;
  Flight flight_;

 private:
  Scenario scenario() {
    factory_.add<test::Direct>("direct");
    factory_.add<test::Watch>("watch");
    Scenario s;
    s.name = "test";
    RobotUse robot;
    robot.name = "quad";
    robot.model = test::quadrotor();
    robot.rotor_speed = 0.0;
    robot.pose.position = {0.0, 0.0, 1.0};
    robot.controllers.push_back(factory_.use("direct", "direct"));
    s.robots.push_back(robot);
    s.task = factory_.use("watch", "task");
    return s;
  }
};

TEST_F(StateGroupTest, BodiesOfAWrittenLaneAreNotShownBeforeTheyFollow) {
  group().writable(layout().q, 1u << 3)[2 * kGroupLanes + 3] = 7.0;
  EXPECT_THROW(group().body_states(3), std::logic_error);
  EXPECT_EQ(group().body_states(2)[0].position.z, 1.0);
  group().refresh(1u << 3, scratch());
  EXPECT_EQ(group().body_states(3)[0].position.z, 7.0);
}

TEST_F(StateGroupTest, APartOfABlockCountsAsTheBlock) {
  const double height = 5.0;
  group().scatter(4, {layout().q.offset + 2, 1}, &height);
  EXPECT_THROW(group().body_states(4), std::logic_error);
  group().writable({layout().params.offset + layout().physics_params - 1, 1}, 1u << 5);
  EXPECT_THROW(group().body_states(5), std::logic_error);
}

TEST_F(StateGroupTest, NothingFollowsFromParametersBehindThePhysicalConstants) {
  const int first = layout().params.offset + layout().physics_params;
  ASSERT_GT(layout().params.size, layout().physics_params) << "starts";
  group().writable({first, layout().params.size - layout().physics_params}, ~0u);
  for (int lane = 0; lane < kGroupLanes; ++lane) EXPECT_NO_THROW(group().body_states(lane));
}

TEST_F(StateGroupTest, NothingFollowsFromCommandsActionsAndPluginStates) {
  for (const Block& block : {layout().rotor_command, layout().wrench, layout().drive,
                             layout().action, layout().command, layout().sensors}) {
    group().writable(block, ~0u);
  }
  group().writable(kStep)[0] = 9;
  group().plugin_bits(0)[0] = 9;
  EXPECT_NO_THROW(group().body_states(0));
}

TEST_F(StateGroupTest, AStepTakesWrittenParametersIntoAccountByItself) {
  const double before = fall(0);
  const double up[3] = {0.0, 0.0, 9.81};  // as much as the weight of 1 kg
  group().scatter(1, {layout().params.offset + layout().robot_params[0], 3}, up);
  EXPECT_NEAR(before, -9.81e-3, 1e-12);
  EXPECT_NEAR(fall(1), 0.0, 1e-12);
}

TEST_F(StateGroupTest, AClearedOrRestoredLaneFollowsAnew) {
  const auto saved = group().save(6);
  group().restore(7, saved);
  EXPECT_THROW(group().body_states(7), std::logic_error);
  group().clear(8);
  EXPECT_THROW(group().body_states(8), std::logic_error);
}

}  // namespace
}  // namespace skybody
