// Motors in joints: closed forms, on all dynamics.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/physics/random_trees.h"

namespace skybody::test {
namespace {

constexpr double kMoment = 0.05;  // moment of inertia about the pin [kg m^2]

/// A rod on a vertical pin, so that gravity exerts no torque.
RobotModel make_rod() {
  RobotModel model;
  model.fixed_base = true;
  model.bodies.push_back(
      make_body("rod", JointType::kPin, -1, 0.5, {0, 0, 0}, diagonal(kMoment, kMoment, kMoment)));
  return model;
}

Bench make_bench(const std::vector<JointDrive>& drives,
                 IntegratorChoice integrator = IntegratorChoice::kRk4, double dt = 0.001) {
  return Bench(make_scenario(make_rod(), integrator, dt),
               [&](WorldPlan& plan) { plan.joint_drives = drives; });
}

JointDrive torque_drive() { return {0, 0, JointMode::kEffort, 0.0, 0.0, kInfinity}; }
JointDrive position_drive(double kp, double kd) {
  return {0, 0, JointMode::kPosition, kp, kd, kInfinity};
}
JointDrive velocity_drive(double kd) { return {0, 0, JointMode::kVelocity, 0.0, kd, kInfinity}; }

TEST(JointDrive, ATorqueAcceleratesARod) {
  Bench bench = make_bench({torque_drive()});
  bench.state.joint_command[0] = 0.2;
  ASSERT_TRUE(bench.run(1000));
  EXPECT_NEAR(bench.state.u[0], 0.2 / kMoment, 1e-11);
  EXPECT_NEAR(bench.state.q[0], 0.5 * 0.2 / kMoment, 1e-11);
}

TEST(JointDrive, APositionDriveSettlesWithItsFrequencyAndDamping) {
  const double kp = 5.0, kd = 0.2, command = 0.8;
  Bench bench = make_bench({position_drive(kp, kd)});
  bench.state.joint_command[0] = command;
  ASSERT_TRUE(bench.run(700));
  const double decay = 0.5 * kd / kMoment, w = std::sqrt(kp / kMoment - decay * decay), t = 0.7;
  const double swing = std::cos(w * t) + decay / w * std::sin(w * t);
  EXPECT_NEAR(bench.state.q[0], command * (1.0 - std::exp(-decay * t) * swing), 1e-8)
      << "rk4: (w h)^5 / 120 a step";
}

TEST(JointDrive, AVelocityDriveApproachesItsSpeed) {
  Bench bench = make_bench({velocity_drive(0.1)});
  bench.state.joint_command[0] = 3.0;
  ASSERT_TRUE(bench.run(600));
  EXPECT_NEAR(bench.state.u[0], 3.0 * (1.0 - std::exp(-0.1 / kMoment * 0.6)), 1e-11);
}

TEST(JointDrive, TheEffortStaysWithinItsLimit) {
  JointDrive strong = position_drive(1000.0, 10.0);
  strong.effort_limit = 0.3;
  Bench bench = make_bench({strong});
  bench.state.joint_command[0] = 100.0;
  ASSERT_TRUE(bench.run(100));
  EXPECT_NEAR(bench.state.u[0], 0.3 / kMoment * 0.1, 1e-12);
  bench.state.joint_command[0] = -100.0;
  ASSERT_TRUE(bench.run(100));
  EXPECT_NEAR(bench.state.u[0], 0.0, 1e-12);
}

TEST(JointDrive, TheCommandIsHeldToItsBounds) {
  JointDrive bounded = torque_drive();
  bounded.low = -0.1;
  bounded.high = 0.2;
  Bench bench = make_bench({bounded});
  bench.state.joint_command[0] = 5.0;
  ASSERT_TRUE(bench.run(100));
  EXPECT_NEAR(bench.state.u[0], 0.2 / kMoment * 0.1, 1e-12);
  bench.state.joint_command[0] = -5.0;
  ASSERT_TRUE(bench.run(200));
  EXPECT_NEAR(bench.state.u[0], 0.0, 1e-12);
}

TEST(JointDrive, TheCommandComesBehindAFirstOrderLag) {
  JointDrive slow = torque_drive();
  slow.tau = 0.05;
  for (const IntegratorChoice integrator : kFixedSteps) {
    Bench bench = make_bench({slow}, integrator);
    bench.state.joint_command[0] = 0.2;
    ASSERT_TRUE(bench.run(100));
    const double t = 0.1, rest = std::exp(-t / slow.tau);
    EXPECT_NEAR(bench.state.joint_state[0], 0.2 * (1.0 - rest), 1e-13);
    // The integral of the torque; other integrators evaluate it in mid-step: error dt^2 / (24
    // tau^2).
    const double speed = 0.2 / kMoment * (t - slow.tau * (1.0 - rest));
    const bool is_rk4 = integrator == IntegratorChoice::kRk4;
    EXPECT_NEAR(bench.state.u[0], speed, (is_rk4 ? 1e-9 : 2e-5) * speed);
  }
}

TEST(JointDrive, WithoutATimeConstantTheStateIsTheCommand) {
  Bench bench = make_bench({torque_drive()});
  bench.state.joint_command[0] = 0.7;
  ASSERT_TRUE(bench.run(1));
  EXPECT_EQ(bench.state.joint_state[0], 0.7);
}

TEST(JointDrive, ConvergesWithTheStepOfEachIntegrator) {
  JointDrive drive = position_drive(5.0, 0.2);
  drive.tau = 0.03;
  const auto angle = [&](IntegratorChoice integrator, double dt) {
    Bench bench = make_bench({drive}, integrator, dt);
    bench.state.joint_command[0] = 0.8;
    EXPECT_TRUE(bench.run_seconds(0.512));
    return bench.state.q[0];
  };
  for (const auto& [integrator, order] :
       {std::pair{IntegratorChoice::kSemiImplicitEuler, 1},
        std::pair{IntegratorChoice::kMidpoint, 2}, std::pair{IntegratorChoice::kRk4, 4}}) {
    const double exact = angle(IntegratorChoice::kRk4, 0.00025);
    const double coarse = std::fabs(angle(integrator, 0.004) - exact);
    const double fine = std::fabs(angle(integrator, 0.002) - exact);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.35) << order;
  }
}

TEST(JointDrive, IntegratorsOfSundialsFollowTheLagInClosedForm) {
  JointDrive drive = position_drive(5.0, 0.2);
  drive.tau = 0.03;
  Scenario scenario = make_scenario(make_rod(), IntegratorChoice::kCvode);
  scenario.stepping.solver.relative_tolerance = 1e-10;
  scenario.stepping.solver.absolute_tolerance = 1e-12;
  Bench exact = make_bench({drive});
  Bench bench(std::move(scenario), [&](WorldPlan& plan) { plan.joint_drives = {drive}; });
  for (Bench* b : {&exact, &bench}) {
    b->state.joint_command[0] = 0.8;
    ASSERT_TRUE(b->run(300));
  }
  EXPECT_NEAR(bench.state.q[0], exact.state.q[0], 1e-7) << "1e-10 in each of some steps a step";
  EXPECT_EQ(bench.state.joint_state, exact.state.joint_state);
}

TEST(JointDrive, BeginsWhereTheJointsAre) {
  const Bench bench = make_bench({position_drive(5.0, 0.2)});
  EXPECT_EQ(bench.state.joint_command, bench.state.q);
  EXPECT_EQ(bench.state.joint_state, bench.state.q);
}

TEST(JointDrive, AStepThatFailsLeavesItsState) {
  Bench bench = make_bench({torque_drive()});
  bench.state.joint_command[0] = kNan;
  EXPECT_FALSE(bench.run(1));
  EXPECT_EQ(bench.state.joint_state[0], 0.0);
  EXPECT_EQ(bench.state.u[0], 0.0);
}

TEST(JointDrive, RefusesJointsThatHaveNoSingleCoordinates) {
  const Topology topology(make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.01))));
  WorldPlan plan(topology);
  plan.joint_drives = {torque_drive()};
  EXPECT_THROW(World(topology, plan), std::logic_error);
  const Topology rod(make_scenario(make_rod()));
  WorldPlan second(rod), twice(rod);
  second.joint_drives = {{0, 1, JointMode::kEffort}};
  EXPECT_THROW(World(rod, second), std::logic_error);
  twice.joint_drives = {torque_drive(), torque_drive()};
  EXPECT_THROW(World(rod, twice), std::logic_error);
}

TEST(JointDrive, TreeAndSimbodyAgree) {
  for (std::uint64_t k = 0; k < 100; ++k) {
    Random<double> random{RandomKey{2026, 51}, k, 0, derive_stream("joint_drive_test")};
    const Topology topology(make_scenario(random_tree(random)));
    WorldPlan plan(topology);
    for (std::size_t i = 0; i < topology.bodies.size(); ++i) {
      const JointType type = topology.bodies[i].model->joint.type;
      if (type == JointType::kBall || type == JointType::kFree) continue;
      for (int c = 0; c < velocity_size(type); ++c) {
        plan.joint_drives.push_back(
            {static_cast<int>(i), c, JointMode::kPosition, 3.0, 0.2, kInfinity});
      }
    }
    if (plan.joint_drives.empty()) continue;
    const World world(topology, plan);
    const auto tree = make_stepper(world), simbody = make_simbody_stepper(world);
    LaneState state;
    write_default_state(world, state);
    random_state(random, world, state.q, state.u);
    for (double& r : state.joint_command) r = random.uniform(-2.0, 2.0);
    std::vector<double> without(state.u.size()), ours = without, theirs = without;
    state.joint_state = state.joint_command;
    tree->accelerations(state, ours.data());
    simbody->accelerations(state, theirs.data());
    // Rounding through ill-conditioned trees, see tree_test.cpp.
    EXPECT_LT(largest_difference(ours, theirs), 1e-6 * (1.0 + largest(ours))) << k;
    state.joint_command[0] = state.joint_state[0] += 1.0;
    tree->accelerations(state, without.data());
    EXPECT_NE(without, ours) << k;
  }
}

}  // namespace
}  // namespace skybody::test
