// Physical constants as EnvParams: a value drawn for one environment changes its motion
// accordingly.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/physics/random_trees.h"

namespace skybody::test {
namespace {

/// A robot whose base is a mass on a slider along x.
RobotModel make_slider(double mass) {
  RobotModel model;
  model.fixed_base = true;
  model.bodies.push_back(
      make_body("mass", JointType::kSlider, -1, mass, {0, 0, 0}, diagonal(0.01, 0.01, 0.01)));
  return model;
}

TEST(Constants, DrawnGravityLetsABodyFallAccordingly) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Scenario scenario = make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.01)), integrator);
    scenario.robots[0].pose.position.z = 10.0;
    Bench bench(std::move(scenario));
    bench.param("gravity[2]") = -1.62;
    ASSERT_TRUE(bench.run_seconds(2.0));
    EXPECT_NEAR(bench.state.u[2], -1.62 * 2.0, 1e-12);
    // Semi-implicit Euler falls further by half a step: g t dt / 2.
    const bool is_euler = integrator == IntegratorChoice::kSemiImplicitEuler;
    EXPECT_NEAR(bench.state.q[2], 10.0 - 0.5 * 1.62 * 4.0, is_euler ? 1.63e-3 : 1e-12);
  }
}

TEST(Constants, DrawnGravityMayLieAslant) {
  Scenario scenario = make_scenario(make_vehicle(qdrone2()), IntegratorChoice::kRk4);
  scenario.robots[0].pose.position.z = 10.0;
  Bench bench(std::move(scenario));
  bench.param("gravity[0]") = 0.5;
  bench.param("gravity[1]") = -0.25;
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_NEAR(bench.state.u[0], 0.5, 1e-12);
  EXPECT_NEAR(bench.state.u[1], -0.25, 1e-12);
}

TEST(Constants, DrawnJointStiffnessSwingsWithItsFrequency) {
  Bench bench(make_scenario(make_slider(0.5), IntegratorChoice::kRk4));
  bench.param("robots.r.joints.mass_joint.stiffness") = 30.0;
  bench.param("robots.r.joints.mass_joint.rest") = 0.2;
  bench.state.q[0] = 0.3;
  const double period = mean_period(upward_crossings(
      bench, [&] { return bench.state.q[0] - 0.2; }, 5000));
  // Linear interpolation between steps: (w h)^2 / 8 of a step.
  EXPECT_NEAR(period, kTwoPi * std::sqrt(0.5 / 30.0), 1e-6);
}

TEST(Constants, DrawnJointDampingDecays) {
  Bench bench(make_scenario(make_slider(0.5), IntegratorChoice::kRk4));
  bench.param("robots.r.joints.mass_joint.damping") = 0.8;
  bench.state.u[0] = 1.0;
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_NEAR(bench.state.u[0], std::exp(-0.8 / 0.5), 1e-12);
}

TEST(Constants, DrawnFrictionStopsASlidingBodyAfterItsWay) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  model.bodies[0].collisions = {make_box(0.2, 0.2, 0.02)};
  Scenario scenario = make_scenario(model);
  scenario.robots[0].pose.position = {0, 0, 0.009};
  Bench bench(std::move(scenario));
  bench.param("contact.friction") = 0.3;
  bench.state.u[0] = 2.0;
  ASSERT_TRUE(bench.run_seconds(3.0));
  EXPECT_NEAR(bench.state.u[0], 0.0, 1e-6);
  // v^2 / (2 mu g), slightly further by the regularisation below some centimetres per second.
  EXPECT_NEAR(bench.state.q[0], 4.0 / (2.0 * 0.3 * 9.81), 0.01);
}

TEST(Constants, AJointHasThoseThatApplyToIt) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  for (const JointType type :
       {JointType::kPin, JointType::kSlider, JointType::kUniversal, JointType::kBall}) {
    const int parent = static_cast<int>(model.bodies.size()) - 1;
    model.bodies.push_back(make_body("b" + std::to_string(parent), type, parent, 0.3, {0, 0, 0.1},
                                     diagonal(0.01, 0.01, 0.01)));
  }
  model.bodies[2].joint.limit = {true, -1.0, 1.0};
  const World world(make_scenario(model));
  const auto has = [&](const std::string& path) {
    return world.layout.find_param("robots.r.joints." + path) >= 0;
  };
  EXPECT_FALSE(has("base_joint.damping")) << "a free base";
  EXPECT_TRUE(has("b0_joint.stiffness") && has("b0_joint.rest")) << "a pin";
  EXPECT_FALSE(has("b0_joint.limit_stiffness")) << "which has no limits";
  EXPECT_TRUE(has("b1_joint.limit_damping")) << "a slider with limits";
  EXPECT_TRUE(has("b2_joint.damping") && has("b3_joint.damping"));
  EXPECT_FALSE(has("b2_joint.stiffness") || has("b3_joint.stiffness"))
      << "universal and ball joints have no spring";
}

/// Gravity, springs and dampers other than the scenario's; some constants are 0.
void draw_constants(Random<double>& random, const World& world, std::vector<double>& params) {
  for (int k = 0; k < 3; ++k)
    params[world.layout.world_params + kGravity + k] = 5.0 * random.uniform();
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const int count = joint_constant_count(world.bodies[i].model->joint);
    for (int k = 0; k < count; ++k) params[world.layout.joint_params[i] + k] = random.uniform();
  }
}

TEST(Constants, TreeAndSimbodyAgreeOnDrawnOnes) {
  for (std::uint64_t k = 0; k < 200; ++k) {
    Random<double> random{RandomKey{2026, 31}, k, 0, derive_stream("constants_test")};
    Bench bench(make_scenario(random_tree(random)));
    const auto simbody = make_simbody_stepper(bench.world);
    random_state(random, bench.world, bench.state.q, bench.state.u);
    bench.stepper->update_bodies(bench.state);
    std::vector<double> nominal(bench.state.u.size()), ours = nominal, theirs = nominal;
    if (nominal.empty()) continue;
    bench.stepper->accelerations(bench.state, nominal.data());
    draw_constants(random, bench.world, bench.state.params);
    bench.stepper->accelerations(bench.state, ours.data());
    simbody->accelerations(bench.state, theirs.data());
    EXPECT_GT(largest_difference(nominal, ours), 1e-3) << k;
    // Rounding through ill-conditioned trees, see tree_test.cpp.
    EXPECT_LT(largest_difference(ours, theirs), 1e-6 * (1.0 + largest(ours))) << k;
  }
}

}  // namespace
}  // namespace skybody::test
