// Reversible rotors, and hover speeds of rotors that do not all push upwards.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

constexpr double kForce = 1e-5, kReaction = 1.6e-7;

Rotor make_rotor(const Vec3<double>& axis, double min_speed = 0.0) {
  Rotor rotor;
  rotor.axis = axis;
  rotor.min_speed = min_speed;
  rotor.constants[kThrustConstant] = kForce;
  rotor.constants[kMomentConstant] = kReaction;
  rotor.constants[kMaxSpeed] = 1000.0;
  return rotor;
}

/// A base of 1 kg and four links of 10 g on hinges, each rolled by `roll` in its joint's frame.
RobotModel make_hinged(double roll, double position) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.02));
  for (int i = 0; i < 4; ++i) {
    Body link;
    link.name = "link_" + std::to_string(i);
    link.joint.type = JointType::kPin;
    link.joint.parent = 0;
    link.joint.position = position;
    // z of the joint's frame, the hinge, along x of the base.
    const Quat<double> hinge = from_axis_angle(Vec3<double>{0, 1, 0}, kHalfPi);
    link.joint.frame_in_parent.rotation = from_axis_angle(Vec3<double>{1, 0, 0}, roll) * hinge;
    link.joint.frame_in_body.rotation = hinge;
    link.mass = {0.01, {0, 0, 0}, diagonal(1e-6, 1e-6, 1e-6)};
    model.bodies.push_back(link);
    Rotor rotor = make_rotor({0.0, std::sin(roll), std::cos(roll)});
    rotor.name = "rotor_" + std::to_string(i);
    rotor.body = i + 1;
    model.rotors.push_back(rotor);
  }
  return model;
}

/// Speed at which four such rotors with upright axes carry 1.04 kg.
const double kUpright = std::sqrt(1.04 * 9.81 / (4.0 * kForce));

TEST(HoverSpeed, IsOfTheAxesInTheFrameOfTheBase) {
  const Scenario scenario = make_scenario(make_hinged(kPi / 3.0, 0.0));
  EXPECT_NEAR(kUpright, 505.03, 0.01);
  EXPECT_NEAR(hover_rotor_speed(scenario, 0), kUpright, 1e-9);
}

TEST(HoverSpeed, KnowsWhereJointsAreAtAReset) {
  // Rolled by 60 degrees in the file and back by 60 degrees in the joint: the axes are 60 degrees
  // off.
  const Scenario scenario = make_scenario(make_hinged(kPi / 3.0, -kPi / 3.0));
  EXPECT_NEAR(hover_rotor_speed(scenario, 0), kUpright / std::sqrt(0.5), 1e-9);
}

TEST(HoverSpeed, IsOfTheRotorsThatLift) {
  RobotModel model = make_free_body(1.5, diagonal(0.01, 0.01, 0.02));
  for (int i = 0; i < 8; ++i) {
    model.rotors.push_back(make_rotor({0.6 * (i % 2 == 0 ? 1 : -1), 0, i < 4 ? 0.8 : -0.8}));
  }
  Scenario scenario = make_scenario(model);
  scenario.robots[0].rotor_speed = -1.0;  // hover
  const Bench bench(scenario);
  const double speed = std::sqrt(1.5 * 9.81 / (4.0 * 0.8 * kForce));
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(bench.state.rotor_speed[i], i < 4 ? speed : 0.0, 1e-9);
  }
}

TEST(HoverSpeed, IsBackwardsWhereReversibleRotorsLiftSo) {
  // Two rotors up and two down, one of which is reversible; k_f w |w| of three carries the weight.
  RobotModel model = make_free_body(1.5, diagonal(0.01, 0.01, 0.02));
  model.rotors = {make_rotor({0, 0, 1}), make_rotor({0.6, 0, -0.8}, -600.0),
                  make_rotor({0, 0, 1}, -600.0), make_rotor({0, 0, -1})};
  Scenario scenario = make_scenario(model);
  scenario.robots[0].rotor_speed = -1.0;  // hover
  const double speed = std::sqrt(1.5 * 9.81 / (2.8 * kForce));
  EXPECT_GT(speed, 600.0);
  const Bench bench(scenario);
  const double expected[] = {speed, -600.0, speed, 0.0};  // clamped to the minimum speed
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(bench.state.rotor_speed[i], expected[i], 1e-9);

  scenario.robots[0].model.rotors.assign(4, make_rotor({0, 0, -1}, -900.0));
  const Bench inverted(scenario);
  const double each = -std::sqrt(1.5 * 9.81 / (4.0 * kForce));
  for (const double w : inverted.state.rotor_speed) EXPECT_NEAR(w, each, 1e-9);
}

Scenario without_pull(Scenario scenario) {
  scenario.constants[kGravity + 2] = 0.0;
  return scenario;
}

/// One reversible rotor on a free body without gravity.
Scenario reversible(double tau, IntegratorChoice integrator, double inertia = 0.0) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.02, 0.03));
  Rotor rotor = make_rotor({0, 0, 1}, -800.0);
  rotor.constants[kTauUp] = rotor.constants[kTauDown] = tau;
  rotor.constants[kRotorInertia] = inertia;
  model.rotors.push_back(rotor);
  return without_pull(make_scenario(model, integrator));
}

TEST(ReversibleRotor, PushesAgainstItsAxisWhereItTurnsBackwards) {
  Bench bench(reversible(0.0, IntegratorChoice::kMidpoint));
  bench.state.rotor_speed[0] = bench.state.rotor_command[0] = -500.0;
  std::vector<double> udot(6);
  bench.stepper->accelerations(bench.state, udot.data());
  EXPECT_NEAR(udot[2], -kForce * 500.0 * 500.0, 1e-12);
  EXPECT_NEAR(udot[5], kReaction * 500.0 * 500.0 / 0.03, 1e-12);  // direction +1 turns it by -k_m
}

TEST(ReversibleRotor, IsHeldToItsLeastSpeed) {
  Bench bench(reversible(0.0, IntegratorChoice::kMidpoint));
  bench.state.rotor_command[0] = -5000.0;
  ASSERT_TRUE(bench.run(1));
  EXPECT_EQ(bench.state.rotor_speed[0], -800.0);
}

TEST(ReversibleRotor, HandsTheWholeImpulseOverWhileItsSpeedChangesItsSign) {
  // Impulse of k_f w |w| along w(t) = c - (c - w0) exp(-t / tau), by fine quadrature.
  for (const double tau : {0.0, 2e-4, 1e-3, 0.02, 0.3}) {
    Bench bench(reversible(tau, IntegratorChoice::kMidpoint));
    const double start = 300.0, command = -700.0, steps = 400;
    bench.state.rotor_speed[0] = start;
    bench.state.rotor_command[0] = command;
    ASSERT_TRUE(bench.run(static_cast<int>(steps)));
    constexpr int kParts = 2'000'000;
    const double end = steps * bench.dt();
    double impulse = 0.0;
    for (int i = 0; i < kParts; ++i) {
      const double t = end * (i + 0.5) / kParts;
      const double w = tau > 0.0 ? command - (command - start) * std::exp(-t / tau) : command;
      impulse += kForce * w * std::abs(w) * end / kParts;
    }
    // The quadrature's own error when the speed jumps within a few of its parts.
    EXPECT_NEAR(bench.state.u[2], impulse, 1e-7 * std::abs(impulse)) << tau;
  }
}

TEST(ReversibleRotor, KeepsTheAngularMomentumOverAChangeOfSign) {
  for (const IntegratorChoice integrator :
       {IntegratorChoice::kMidpoint, IntegratorChoice::kSemiImplicitEuler,
        IntegratorChoice::kRk4}) {
    Bench bench(reversible(0.0125, integrator, 1e-4));
    bench.state.rotor_speed[0] = 600.0;
    bench.state.rotor_command[0] = -600.0;
    bench.param("robots.r.rotors[0].moment_constant") = 0.0;
    ASSERT_TRUE(bench.run(50));
    EXPECT_NEAR(0.03 * bench.state.u[5] + 1e-4 * bench.state.rotor_speed[0], 1e-4 * 600.0, 1e-14);
  }
}

TEST(ReversibleRotor, DragsAgainstTheVelocityInBothSenses) {
  for (const double speed : {700.0, -700.0}) {
    Bench bench(reversible(0.0, IntegratorChoice::kMidpoint));
    bench.param("robots.r.rotors[0].drag_constant") = 1e-4;
    bench.state.rotor_speed[0] = bench.state.rotor_command[0] = speed;
    bench.state.u[0] = 3.0;
    std::vector<double> udot(6);
    bench.stepper->accelerations(bench.state, udot.data());
    EXPECT_NEAR(udot[0], -1e-4 * 700.0 * 3.0, 1e-12);
  }
}

}  // namespace
}  // namespace skybody::test
