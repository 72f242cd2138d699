// CVODE and ARKODE against closed forms and rk4, and guarantees of their steps.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <ostream>

#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

struct Solver {
  const char* name;
  IntegratorChoice integrator;
  SolverMethod method;
};

void PrintTo(const Solver& solver, std::ostream* out) { *out << solver.name; }

constexpr Solver kSolvers[] = {
    {"Adams", IntegratorChoice::kCvode, SolverMethod::kAdams},
    {"Bdf", IntegratorChoice::kCvode, SolverMethod::kBdf},
    {"Erk", IntegratorChoice::kArkode, SolverMethod::kErk},
    {"Dirk", IntegratorChoice::kArkode, SolverMethod::kDirk},
};

Scenario with(const Solver& solver, double tolerance, Scenario scenario) {
  scenario.stepping.integrator = solver.integrator;
  scenario.stepping.solver.method = solver.method;
  scenario.stepping.solver.relative_tolerance = tolerance;
  scenario.stepping.solver.absolute_tolerance = 1e-3 * tolerance;
  return scenario;
}

Scenario vehicle(DynamicsChoice dynamics = DynamicsChoice::kTree) {
  RobotModel model = make_vehicle(qdrone2());
  for (Rotor& rotor : model.rotors) {
    rotor.constants[kDragConstant] = 2e-4;
    rotor.constants[kRollingMomentConstant] = 1e-5;
    rotor.constants[kRotorInertia] = 5e-6;
  }
  Scenario scenario = make_scenario(model);
  scenario.stepping.dynamics = dynamics;
  return scenario;
}

void start_flight(Bench& bench) {
  bench.state.q[2] = 50.0;
  bench.state.u = {3.0, -1.0, 0.5, 0.3, 0.2, -0.1};
  bench.state.rotor_speed.assign(4, 1000.0);
  bench.state.rotor_command = {1500.0, 1520.0, 1490.0, 1510.0};
  bench.stepper->update_bodies(bench.state);
}

/// q and u after 0.1 s of flight with rotor drag, rolling moment and lag.
std::vector<double> fly(Scenario scenario) {
  Bench bench(std::move(scenario));
  start_flight(bench);
  EXPECT_TRUE(bench.run_seconds(0.1));
  std::vector<double> out = bench.state.q;
  out.insert(out.end(), bench.state.u.begin(), bench.state.u.end());
  return out;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::fmax(most, std::fabs(a[i] - b[i]));
  return most;
}

class EverySolver : public testing::TestWithParam<Solver> {};

TEST_P(EverySolver, FliesAsRk4DoesInSmallSteps) {
  Scenario fine = vehicle();
  fine.stepping.integrator = IntegratorChoice::kRk4;
  fine.stepping.dt = 5e-5;  // (dt / tau)^4: far below the requested tolerance
  const std::vector<double> exact = fly(fine);
  for (const DynamicsChoice dynamics : {DynamicsChoice::kTree, DynamicsChoice::kSimbody}) {
    // Values are up to 100 in size; a hundred steps each add an error within the tolerance.
    EXPECT_LT(distance(fly(with(GetParam(), 1e-10, vehicle(dynamics))), exact), 1e-6);
  }
}

TEST_P(EverySolver, IsMoreExactWithATighterTolerance) {
  Scenario coarse = vehicle();
  coarse.stepping.dt = 0.02;  // several solver steps per physics step
  const std::vector<double> exact = fly(with(GetParam(), 1e-11, coarse));
  const double tight = distance(fly(with(GetParam(), 1e-8, coarse)), exact);
  const double loose = distance(fly(with(GetParam(), 1e-4, coarse)), exact);
  EXPECT_LT(tight, 0.1 * loose);
  EXPECT_LT(loose, 0.1);
}

/// A pin with a spring and a damper: q'' + 2 z w q' + w^2 q = 0.
Scenario spring(double rate, double damping_ratio) {
  constexpr double kInertia = 1e-3;
  RobotModel model;
  model.fixed_base = true;
  model.bodies.push_back(make_body("flap", JointType::kPin, -1, 0.1, {0, 0, 0},
                                   diagonal(kInertia, kInertia, kInertia)));
  model.bodies[0].joint.constants[kJointStiffness] = kInertia * rate * rate;
  model.bodies[0].joint.constants[kJointDamping] = 2.0 * damping_ratio * rate * kInertia;
  return make_scenario(model);
}

TEST_P(EverySolver, SwingsASpringAsTheClosedFormSays) {
  constexpr double kRate = 2000.0, kRatio = 0.1, kTime = 0.02;
  Bench bench(with(GetParam(), 1e-9, spring(kRate, kRatio)));
  bench.state.q[0] = 0.1;
  bench.stepper->update_bodies(bench.state);
  ASSERT_TRUE(bench.run_seconds(kTime));
  const double damped = kRate * std::sqrt(1.0 - kRatio * kRatio);
  const double expected =
      0.1 * std::exp(-kRatio * kRate * kTime) *
      (std::cos(damped * kTime) + kRatio * kRate / damped * std::sin(damped * kTime));
  EXPECT_NEAR(bench.state.q[0], expected, 1e-6);
}

TEST(Cvode, KeepsAPendulumsEnergyForAMinuteByDefault) {
  RobotModel model;
  model.fixed_base = true;
  model.bodies.push_back(
      make_body("rod", JointType::kPin, -1, 0.4, {0, -0.35, 0}, diagonal(0.01, 0.01, 0.01)));
  // The pin's axis is z of its frame: make it horizontal.
  model.bodies[0].joint.frame_in_parent.rotation = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};
  Scenario scenario = make_scenario(model);
  scenario.contact.ground = false;
  scenario.stepping.integrator = IntegratorChoice::kCvode;
  Bench bench(scenario);
  const auto energy = [&] {
    const double q = bench.state.q[0], u = bench.state.u[0];
    const double moment = 0.01 + 0.4 * 0.35 * 0.35;
    return 0.5 * moment * u * u + 0.4 * 9.81 * 0.35 * (1.0 - std::cos(q));
  };
  bench.state.q[0] = 1.0;
  bench.stepper->update_bodies(bench.state);
  const double before = energy();
  ASSERT_TRUE(bench.run_seconds(60.0));
  // It loses 6e-4; at 1e-6 it would lose 2e-2.
  EXPECT_NEAR(energy() / before, 1.0, 1e-3);
}

TEST_P(EverySolver, BearsASpringTooStiffForFixedSteps) {
  const Scenario stiff = spring(2e4, 1.0);
  for (const auto fixed : kFixedSteps) {
    Scenario scenario = stiff;
    scenario.stepping.integrator = fixed;
    Bench bench(scenario);
    bench.state.q[0] = 0.1;
    bench.stepper->update_bodies(bench.state);
    EXPECT_FALSE(bench.run_seconds(0.1));
  }
  Bench bench(with(GetParam(), 1e-6, stiff));
  bench.state.q[0] = 0.1;
  bench.stepper->update_bodies(bench.state);
  ASSERT_TRUE(bench.run_seconds(0.1));
  EXPECT_NEAR(bench.state.q[0], 0.0, 1e-6);
}

bool same_bits(const LaneState& a, const LaneState& b) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0;
  };
  return same(a.q, b.q) && same(a.u, b.u) && same(a.rotor_speed, b.rotor_speed) &&
         std::memcmp(a.bodies.data(), b.bodies.data(), a.bodies.size() * sizeof(BodyState)) == 0;
}

TEST_P(EverySolver, RemembersNothingOfTheStepsBefore) {
  for (const DynamicsChoice dynamics : {DynamicsChoice::kTree, DynamicsChoice::kSimbody}) {
    Bench used(with(GetParam(), 1e-6, vehicle(dynamics)));
    start_flight(used);
    ASSERT_TRUE(used.run(20));
    Bench fresh(with(GetParam(), 1e-6, vehicle(dynamics)));
    fresh.state = used.state;
    ASSERT_TRUE(used.run(20));
    ASSERT_TRUE(fresh.run(20));
    EXPECT_TRUE(same_bits(used.state, fresh.state));
  }
}

TEST_P(EverySolver, GivesUpAfterTheMostStepsAndLeavesTheStateAsItWas) {
  Scenario scenario = with(GetParam(), 1e-12, spring(2e4, 0.01));
  scenario.stepping.solver.max_steps = 3;
  Bench bench(scenario);
  bench.state.q[0] = 0.1;
  bench.stepper->update_bodies(bench.state);
  const LaneState before = bench.state;
  EXPECT_FALSE(bench.stepper->advance(bench.state));
  EXPECT_TRUE(same_bits(before, bench.state));
}

TEST_P(EverySolver, GivesUpOnAStateThatIsNotFinite) {
  Bench bench(with(GetParam(), 1e-6, vehicle()));
  start_flight(bench);
  bench.state.u[0] = std::nan("");
  EXPECT_FALSE(bench.stepper->advance(bench.state));
  start_flight(bench);
  EXPECT_TRUE(bench.stepper->advance(bench.state)) << "and goes on with the next that is";
}

/// A stiff contact, without a limit by the step, carries the weight at the scenario's penetration.
TEST_P(EverySolver, RestsOnStiffGroundAsDeepAsTheScenarioSays) {
  Scenario scenario = with(GetParam(), 1e-6, make_scenario(make_vehicle(qdrone2())));
  scenario.contact.penetration = 0.000215;
  Bench bench(scenario);
  bench.state.q[2] = clearance(qdrone2()) + 0.001;
  bench.stepper->update_bodies(bench.state);
  ASSERT_TRUE(bench.run_seconds(0.5));
  EXPECT_NEAR(bench.state.q[2], clearance(qdrone2()) - 0.000215, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Sundials, EverySolver, testing::ValuesIn(kSolvers),
                         [](const auto& solver) { return solver.param.name; });

}  // namespace
}  // namespace skybody::test
