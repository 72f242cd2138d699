// Geometry and statics of the shipped arm in the hold baseline.
#include "core/policy/hold/arm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/policy/hold/hold_policy.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

class ShippedArm : public ::testing::Test {
 protected:
  Simulation simulation{{.scenario = "arm", .overrides = {"randomization=[]"}}};
  const World& world = simulation.compiled().world();
  const Vec3<double> tip{0.0, 0.0, -0.2};

  std::vector<JointDrive> drives() const {
    std::vector<JointDrive> all;
    for (const PluginInstance& use : simulation.compiled().plugins(SKYBODY_CONTROLLER)) {
      all.insert(all.end(), use.controller.joints.begin(), use.controller.joints.end());
    }
    return all;
  }
  Arm arm() const { return {world, 0, 2, tip, drives()}; }
};

TEST_F(ShippedArm, PlacesItsTipByTheAnglesOfTwoLinks) {
  const Arm two = arm();
  ASSERT_TRUE(two.can_reach());
  for (const double shoulder : {-1.0, 0.0, 0.7}) {
    for (const double elbow : {0.0, 0.8, 2.0}) {
      const Vec3<double> p = two.place({shoulder, elbow});
      const double x = -0.2 * (std::sin(shoulder) + std::sin(shoulder + elbow));
      const double z = -0.105 - 0.2 * (std::cos(shoulder) + std::cos(shoulder + elbow));
      // The URDF's axes pass through quaternions of 10 digits.
      EXPECT_NEAR(p.x, x, 1e-9);
      EXPECT_NEAR(p.y, 0.0, 1e-9);
      EXPECT_NEAR(p.z, z, 1e-9);
    }
  }
}

TEST_F(ShippedArm, FindsAnglesForEveryPlaceThatTheScenarioDraws) {
  const Arm two = arm();
  for (double x = -0.12; x <= 0.181; x += 0.01) {
    for (double z = -0.42; z <= -0.284; z += 0.005) {
      const Vec3<double> p = two.place(two.reach({x, 0.0, z}));
      // Each of the 40 steps leaves a hundredth of the error: it ends at its own limit, 1e-9 m.
      EXPECT_NEAR(std::hypot(p.x - x, p.y, p.z - z), 0.0, 1e-8) << x << " " << z;
    }
  }
}

TEST_F(ShippedArm, ComesNearATargetBesideItsPlaneAndStaysWithinItsLimits) {
  const Arm two = arm();
  const Vec3<double> beside = two.place(two.reach({0.05, 0.3, -0.35}));
  EXPECT_NEAR(std::hypot(beside.x - 0.05, beside.z + 0.35), 0.0, 1e-3);
  const std::vector<double> far = two.reach({0.0, 0.0, 5.0});
  ASSERT_EQ(far.size(), 2u);
  EXPECT_TRUE(far[0] >= -1.9 && far[0] <= 1.9) << far[0];  // the limits in the URDF
  EXPECT_TRUE(far[1] >= 0.0 && far[1] <= 2.5) << far[1];
}

TEST_F(ShippedArm, CannotReachWithAJointThatNothingDrives) {
  EXPECT_FALSE(Arm(world, 0, 2, tip, {drives()[0]}).can_reach());
  EXPECT_FALSE(Arm(world, 0, 0, tip, drives()).can_reach());
  EXPECT_FALSE(Arm().can_reach());
}

TEST_F(ShippedArm, UnderHoldStandsStillWithItsTipInPlaceWhereverItIs) {
  HoldPolicy hold(simulation.compiled());
  std::vector<float> action(static_cast<std::size_t>(simulation.compiled().action_size()));
  for (const double x : {-0.12, 0.0, 0.18}) {
    simulation.reset();
    simulation.set_param("task.place[0]", x);
    simulation.set_param("task.place[2]", -0.3);
    for (int k = 0; k < 1000; ++k) {
      hold.act(simulation, action);
      simulation.step(action);
    }
    const std::vector<BodyState> bodies = simulation.bodies();
    const BodyState &base = bodies[0], &forearm = bodies[2];
    const Vec3<double> tool = forearm.position + rotate(forearm.rotation, tip);
    // The hold baseline compensates the arm's weight from its model, so the only offset is the
    // residual of loops with poles at 2 rad/s after 10 s: a step of 0.1 m times 20 e^-20, far below
    // a tenth of a millimetre.
    EXPECT_NEAR(norm(base.position - Vec3<double>{0.0, 0.0, 2.0}), 0.0, 1e-4) << x;
    EXPECT_NEAR(norm(tool - Vec3<double>{x, 0.0, 1.7}), 0.0, 1e-4) << x;
  }
}

}  // namespace
}  // namespace skybody
