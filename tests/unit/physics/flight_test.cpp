// Free bodies and rotors against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

constexpr auto kEuler = IntegratorChoice::kSemiImplicitEuler;
constexpr auto kRk4 = IntegratorChoice::kRk4;

Scenario without_gravity(Scenario scenario) {
  scenario.constants[kGravity + 2] = 0.0;
  return scenario;
}

TEST(FreeFall, SemiImplicitEulerFollowsItsOwnClosedForm) {
  Bench bench(make_scenario(make_free_body(1.5, diagonal(0.01, 0.02, 0.025), {0.1, 0.02, -0.03})));
  bench.state.q[2] = 100.0;
  bench.state.u[0] = 1.0;
  const int n = 1000;
  ASSERT_TRUE(bench.run(n));
  // z_n = z_0 - g h^2 n (n + 1) / 2; 1000 roundings of 1e-14 each.
  const double h = bench.dt();
  EXPECT_NEAR(bench.state.q[2], 100.0 - 9.81 * h * h * n * (n + 1) / 2.0, 1e-11);
  EXPECT_NEAR(bench.state.u[2], -9.81 * n * h, 1e-12);
  EXPECT_NEAR(bench.state.q[0], 1.0, 1e-12);
  EXPECT_NEAR(bench.state.u[4], 0.0, 1e-12) << "gravity does not turn a body";
}

TEST(FreeFall, MidpointAndRk4AreExact) {
  for (const IntegratorChoice integrator : {IntegratorChoice::kMidpoint, kRk4}) {
    Bench bench(make_scenario(make_free_body(1.5, diagonal(0.01, 0.02, 0.025)), integrator, 0.01));
    bench.state.q[2] = 100.0;
    ASSERT_TRUE(bench.run(100));
    // The integration of a parabola is exact up to rounding.
    EXPECT_NEAR(bench.state.q[2], 100.0 - 0.5 * 9.81, 1e-11);
    EXPECT_NEAR(bench.state.bodies[0].position.z, bench.state.q[2], 0.0);
  }
}

TEST(FreeSpin, MidpointKeepsTheEnergyOfAMinute) {
  const RobotModel model = make_free_body(1.54, diagonal(0.0147, 0.0169, 0.0294));
  Bench bench(without_gravity(make_scenario(model, IntegratorChoice::kMidpoint)));
  bench.state.u[3] = 4.0;
  bench.state.u[4] = 5.0;
  bench.state.u[5] = 3.0;
  bench.stepper->update_bodies(bench.state);
  const double energy = kinetic_energy(bench.state.bodies[0], model.bodies[0].mass);
  ASSERT_TRUE(bench.run_seconds(60.0));
  // Third order in the step: 6e-7 by the same rule in NumPy.
  EXPECT_NEAR(kinetic_energy(bench.state.bodies[0], model.bodies[0].mass) / energy, 1.0, 1e-6);
}

TEST(AsymmetricTop, Rk4KeepsEnergyAndAngularMomentumForAHundredThousandSteps) {
  const RobotModel model = make_free_body(1.54, diagonal(0.0147, 0.0169, 0.0294));
  const MassProperties mass = model.bodies[0].mass;
  Bench bench(without_gravity(make_scenario(model, kRk4)));
  bench.state.u[3] = 3.0;
  bench.state.u[4] = 4.0;
  bench.state.u[5] = 1.0;
  bench.stepper->update_bodies(bench.state);
  const double energy = kinetic_energy(bench.state.bodies[0], mass);
  const Vec3<double> momentum = spin_momentum(bench.state.bodies[0], mass);
  ASSERT_TRUE(bench.run(100000));
  // Local error (w h)^5 / 120 = 2.6e-14 a step, mostly in phase: 1e5 steps stay below 1e-8.
  EXPECT_NEAR(kinetic_energy(bench.state.bodies[0], mass) / energy, 1.0, 1e-8);
  const Vec3<double> drift = spin_momentum(bench.state.bodies[0], mass) - momentum;
  EXPECT_LT(norm(drift) / norm(momentum), 1e-8);
}

TEST(AsymmetricTop, FlipsAboutItsIntermediateAxis) {
  const RobotModel model = make_free_body(1.0, diagonal(0.01, 0.02, 0.03));
  Bench bench(without_gravity(make_scenario(model, kRk4)));
  bench.state.u[3] = 1e-3;
  bench.state.u[4] = 10.0;
  double least = 10.0, most_back = -10.0;
  bool flipped = false;
  for (int i = 0; i < 10000; ++i) {
    ASSERT_TRUE(bench.run(1));
    least = std::fmin(least, bench.state.u[4]);
    flipped = flipped || bench.state.u[4] < -9.9;
    if (flipped) most_back = std::fmax(most_back, bench.state.u[4]);
  }
  EXPECT_LT(least, -9.9) << "turned over";
  EXPECT_GT(most_back, 9.9) << "and back again";
}

TEST(AsymmetricTop, SpinsOnAboutItsLargestAxis) {
  Bench bench(
      without_gravity(make_scenario(make_free_body(1.0, diagonal(0.01, 0.02, 0.03)), kRk4)));
  bench.state.u[3] = 1e-3;
  bench.state.u[5] = 10.0;
  for (int i = 0; i < 5000; ++i) {
    ASSERT_TRUE(bench.run(1));
    ASSERT_GT(bench.state.u[5], 9.99);
  }
}

/// Rotation and spin after 0.5 s of tumbling.
std::vector<double> tumble(IntegratorChoice integrator, double dt) {
  Bench bench(without_gravity(
      make_scenario(make_free_body(1.0, diagonal(0.0147, 0.0169, 0.0294)), integrator, dt)));
  bench.state.u[3] = 3.0;
  bench.state.u[4] = 4.0;
  bench.state.u[5] = 1.0;
  EXPECT_TRUE(bench.run_seconds(0.5));
  std::vector<double> out(bench.state.q.begin() + 3, bench.state.q.end());
  out.insert(out.end(), bench.state.u.begin() + 3, bench.state.u.end());
  return out;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

TEST(AsymmetricTop, SemiImplicitEulerConvergesWithFirstOrder) {
  const std::vector<double> exact = tumble(kRk4, 5e-4);
  const double coarse = distance(tumble(kEuler, 2e-3), exact);
  const double fine = distance(tumble(kEuler, 1e-3), exact);
  // Half of dt gives half of the error up to the second-order term.
  EXPECT_NEAR(coarse / fine, 2.0, 0.1);
}

TEST(Hover, SpeedFromThrustConstantAndMassBalancesGravity) {
  for (const VehicleData& data : {qdrone2(), crazyflie(), hummingbird(), firefly()}) {
    Scenario scenario = make_scenario(make_vehicle(data));
    scenario.robots[0].pose.position = {0, 0, 5};
    scenario.robots[0].rotor_speed = -1.0;
    Bench bench(std::move(scenario));
    EXPECT_NEAR(bench.state.rotor_speed[0], std::sqrt(data.mass * 9.81 / (data.rotors * data.kf)),
                1e-9);
    ASSERT_TRUE(bench.run(1000));
    // One ulp of g as a residual gives 1e-15 m; rounding over 1000 steps is some hundred times as
    // large.
    EXPECT_NEAR(bench.state.q[2], 5.0, 1e-11);
    EXPECT_NEAR(norm(bench.state.bodies[0].angular_velocity), 0.0, 1e-10);
  }
}

TEST(RotorLag, FollowsTheExponentialUpAndDownAtAnyStep) {
  for (const double dt : {0.0005, 0.001, 0.004, 0.05}) {
    Bench bench(make_scenario(make_vehicle(qdrone2()), kEuler, dt));
    bench.state.rotor_speed.assign(4, 500.0);
    bench.state.rotor_command = {1500.0, 100.0, 500.0, 5000.0};
    const int n = 20;
    bench.state.q[2] = 50.0;
    ASSERT_TRUE(bench.run(n));
    const double t = n * dt;
    // The closed form is exact over several steps; 20 roundings of 1e-13 at 1000 rad/s.
    EXPECT_NEAR(bench.state.rotor_speed[0], 1500 - 1000 * std::exp(-t / 0.0125), 1e-10);
    EXPECT_NEAR(bench.state.rotor_speed[1], 100 + 400 * std::exp(-t / 0.025), 1e-10);
    EXPECT_EQ(bench.state.rotor_speed[2], 500.0);
    EXPECT_NEAR(bench.state.rotor_speed[3], 2246 - 1746 * std::exp(-t / 0.0125), 1e-10)
        << "limited to the largest speed";
  }
}

TEST(RotorLag, NegativeCommandsAreLimitedToStandstill) {
  Bench bench(make_scenario(make_vehicle(qdrone2())));
  bench.state.q[2] = 50.0;
  bench.state.rotor_speed.assign(4, 300.0);
  bench.state.rotor_command.assign(4, -1000.0);
  ASSERT_TRUE(bench.run(2000));
  for (const double speed : bench.state.rotor_speed) {
    EXPECT_GE(speed, 0.0);
    EXPECT_LT(speed, 1e-12);
  }
}

TEST(RotorLag, ZeroTimeConstantIsImmediate) {
  VehicleData data = qdrone2();
  data.tau_up = data.tau_down = 0.0;
  Bench bench(make_scenario(make_vehicle(data)));
  bench.state.q[2] = 50.0;
  bench.state.rotor_command.assign(4, 1234.5);
  std::vector<double> udot(6);
  bench.stepper->accelerations(bench.state, udot.data());
  EXPECT_NEAR(udot[2], 4 * data.kf * 1234.5 * 1234.5 / data.mass - 9.81, 1e-12)
      << "the command acts from the start of the step";
  ASSERT_TRUE(bench.run(1));
  EXPECT_EQ(bench.state.rotor_speed[0], 1234.5);
}

TEST(Rotor, AnActionActsOnTheVeryNextPhysicsStep) {
  Bench bench(make_scenario(make_vehicle(qdrone2())));
  bench.state.q[2] = 50.0;
  bench.state.rotor_command.assign(4, 2000.0);
  ASSERT_TRUE(bench.run(1));
  const double mid = 2000.0 * (1.0 - std::exp(-0.0005 / 0.0125));
  const double thrust = 4 * 1.9533e-6 * mid * mid;
  // Rounding of g against a thrust of some 0.05 N.
  EXPECT_NEAR(bench.state.u[2], 0.001 * (thrust / 1.54 - 9.81), 1e-15);
}

TEST(Rotor, ReactionTurnsTheBodyAgainstTheRotors) {
  RobotModel model = make_vehicle(qdrone2());
  for (Rotor& rotor : model.rotors) rotor.direction = 1;
  Bench bench(make_scenario(model));
  bench.state.q[2] = 50.0;
  bench.state.rotor_speed.assign(4, 1000.0);
  bench.state.rotor_command.assign(4, 1000.0);
  std::vector<double> udot(6);
  bench.stepper->accelerations(bench.state, udot.data());
  EXPECT_NEAR(udot[5], -4 * 2.8401e-8 * 1e6 / 0.0294, 1e-12);
}

TEST(Rotor, DragAndRollingMomentOpposeMotionAcrossTheAxis) {
  RobotModel model = make_vehicle(qdrone2());
  for (Rotor& rotor : model.rotors) {
    rotor.direction = 1;
    rotor.constants[kDragConstant] = 2e-5;
    rotor.constants[kRollingMomentConstant] = 1e-6;
  }
  Bench bench(without_gravity(make_scenario(model)));
  bench.state.q[2] = 50.0;
  bench.state.u[0] = 2.0;
  bench.state.u[2] = 3.0;  // along the axis: no drag
  bench.state.rotor_speed.assign(4, 1000.0);
  bench.state.rotor_command.assign(4, 1000.0);
  std::vector<double> udot(6);
  bench.stepper->accelerations(bench.state, udot.data());
  EXPECT_NEAR(udot[0], -4 * 2e-5 * 1000 * 2.0 / 1.54, 1e-13);
  EXPECT_NEAR(udot[3], -4 * 1e-6 * 1000 * 2.0 / 0.0147, 1e-12);
  EXPECT_NEAR(udot[2], 4 * 1.9533 / 1.54, 1e-12);
}

TEST(Rotor, SpinningRotorPrecessesTheBody) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.02, 0.03));
  Rotor rotor;
  rotor.direction = -1;
  rotor.constants[kRotorInertia] = 1e-4;
  rotor.constants[kMaxSpeed] = 2000;
  model.rotors.push_back(rotor);
  Bench bench(without_gravity(make_scenario(model)));
  bench.state.q[2] = 10.0;
  bench.state.rotor_speed[0] = bench.state.rotor_command[0] = 1000.0;
  bench.state.u[3] = 2.0;  // about x
  std::vector<double> udot(6);
  bench.stepper->accelerations(bench.state, udot.data());
  // M = -w x (s J w_r z) = -(2, 0, 0) x (0, 0, -0.1) = (0, -0.2, 0).
  EXPECT_NEAR(udot[4], -0.2 / 0.02, 1e-12);
  EXPECT_NEAR(udot[3], 0.0, 1e-12);
}

TEST(Rotor, SpinUpHandsItsAngularMomentumToTheBody) {
  for (const IntegratorChoice integrator : {kEuler, kRk4}) {
    for (const double tau : {0.0, 1e-4, 0.0125}) {
      RobotModel model = make_free_body(1.0, diagonal(0.01, 0.02, 0.03));
      Rotor rotor;
      rotor.constants[kRotorInertia] = 1e-4;
      rotor.constants[kMaxSpeed] = 2000;
      rotor.constants[kTauUp] = rotor.constants[kTauDown] = tau;
      model.rotors.push_back(rotor);
      Bench bench(without_gravity(make_scenario(model, integrator)));
      bench.state.q[2] = 10.0;
      bench.state.rotor_command[0] = 1000.0;
      ASSERT_TRUE(bench.run(30));
      // Total angular momentum about z stays zero, for any time constant.
      EXPECT_NEAR(0.03 * bench.state.u[5] + 1e-4 * bench.state.rotor_speed[0], 0.0, 1e-14);
    }
  }
}

/// Position and velocity after 0.2 s of flight with rotor drag, rolling moment and lag.
std::vector<double> fly_with_drag(IntegratorChoice integrator, double dt) {
  RobotModel model = make_vehicle(qdrone2());
  for (Rotor& rotor : model.rotors) {
    rotor.constants[kDragConstant] = 2e-4;
    rotor.constants[kRollingMomentConstant] = 1e-5;
    rotor.constants[kRotorInertia] = 5e-6;
  }
  Bench bench(make_scenario(model, integrator, dt));
  bench.state.q[2] = 50.0;
  bench.state.u = {3.0, -1.0, 0.5, 0.3, 0.2, -0.1};
  bench.state.rotor_speed.assign(4, 1000.0);
  bench.state.rotor_command = {1500.0, 1520.0, 1490.0, 1510.0};
  EXPECT_TRUE(bench.run_seconds(0.2));
  std::vector<double> out = bench.state.q;
  out.insert(out.end(), bench.state.u.begin(), bench.state.u.end());
  return out;
}

TEST(Convergence, SemiImplicitEulerIsOfFirstOrderWithVelocityDependentDrag) {
  const std::vector<double> exact = fly_with_drag(kRk4, 2.5e-4);
  const double coarse = distance(fly_with_drag(kEuler, 1e-3), exact);
  const double fine = distance(fly_with_drag(kEuler, 5e-4), exact);
  EXPECT_NEAR(std::log2(coarse / fine), 1.0, 0.1);
}

TEST(Convergence, Rk4IsOfFourthOrderWithVelocityDependentDrag) {
  const std::vector<double> exact = fly_with_drag(kRk4, 2.5e-4);
  const double coarse = distance(fly_with_drag(kRk4, 8e-3), exact);
  const double fine = distance(fly_with_drag(kRk4, 4e-3), exact);
  // dt / tau is a third at the finer step, so the asymptotic order is not fully reached.
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.4);
}

}  // namespace
}  // namespace skybody::test
