// Motors against their equation: closed forms, a fine integration, the limits, and steps of any
// size.
#include <algorithm>
#include <cmath>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

/// J dw/dt = k i - k_m w^2 - friction by small steps of the classical Runge-Kutta method.
struct Reference {
  double torque = 0.0055, resistance = 0.1, max_current = 30.0, supply = 16.8, friction = 0.002;
  double inertia = 4.92e-6, drag = 2.8401e-8;
  bool brake = true;

  double rate(double w, double command) const {
    const double steady = drag * command * command + friction;
    const double volts = std::min(torque * command + resistance / torque * steady, supply);
    const double free = (volts - torque * w) / resistance;
    const double current = std::clamp(free, brake ? -max_current : 0.0, max_current);
    return (torque * current - drag * w * w - friction) / inertia;
  }
  double after(double w, double command, double time) const {
    const int steps = std::max(1, static_cast<int>(std::lround(time / 1e-6)));
    const double h = time / steps;
    for (int i = 0; i < steps; ++i) {
      const double a = rate(w, command), b = rate(w + 0.5 * h * a, command);
      const double c = rate(w + 0.5 * h * b, command), d = rate(w + h * c, command);
      w += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    return w;
  }
};

class MotorTest : public ::testing::Test {
 protected:
  MotorTest() { world.add_quad("quad"); }

  Parameters given(const Parameters& others = {}) const {
    Parameters all = others;
    all.insert({{"torque_constant", 0.0055},
                {"resistance", 0.1},
                {"max_current", 30.0},
                {"voltage", 16.8},
                {"friction", 0.002}});
    return all;
  }
  static void set_constant(const PluginWorld& w, Group& g, int constant, double value) {
    for (const SkybodyRotorInfo& rotor : w.rotors) {
      for (int l = 0; l < g.lanes; ++l) g.at(g.params, rotor.first_param + constant, l) = value;
    }
  }
  /// A step as in the engine, with rotor 0 only.
  double step(const Instance& motor, Group& g, double command) const {
    g.held = motor.group(1).held;
    std::fill(g.rotor_command.begin(), g.rotor_command.end(), command);
    motor.call(Call::kApply, g);
    const double rate = g.held[SKYBODY_HELD_ROTOR_RATE][0];
    const double speed = std::clamp(g.rotor_speed[0] + rate * world.dt, 0.0, 2246.0);
    std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), speed);
    return rate;
  }
  PluginWorld world;
};

TEST_F(MotorTest, GivesTheBitsOfDouble) {
  expect_same_bits("motor", world, given());
  expect_same_bits("motor", world, given({{"brake", false}, {"max_current", 12.0}}));
}

TEST_F(MotorTest, ComesToTheCommandedSpeed) {
  const Instance motor("motor", world, given());
  Group g = motor.group(1);
  for (const double command : {500.0, 2100.0, 900.0}) {
    for (int i = 0; i < 1000; ++i) step(motor, g, command);
    EXPECT_NEAR(g.rotor_speed[0], command,
                1e-9 * command);  // one second; the time constant is 16 ms
  }
}

TEST_F(MotorTest, WithoutDragOfTheAirIsExactWhateverTheStep) {
  for (const double dt : {1e-4, 1e-3, 0.02}) {
    world.dt = dt;
    const Instance motor("motor", world, given({{"max_current", 1e5}}));
    Group g = motor.group(1);
    set_constant(world, g, SKYBODY_ROTOR_MOMENT_CONSTANT, 0.0);
    const double tau = 0.1 * 4.92e-6 / (0.0055 * 0.0055);
    for (int i = 1; i * dt < 0.081; ++i) {
      step(motor, g, 1500.0);
      // Rounding of a few steps' products; friction is part of the voltage and cancels.
      EXPECT_NEAR(g.rotor_speed[0], 1500.0 * (1.0 - std::exp(-i * dt / tau)), 1e-9);
    }
  }
}

/// Commands one after another, each held for the same time.
struct Flight {
  double start, hold;
  std::vector<double> commands;
};
/// Up at the current limit, about the hover speed, down at the limit; long and short steps.
const Flight kFlights[] = {{0.0, 0.1, {2000, 1390, 300, 1300}},
                           {1000.0, 0.1, {2000, 300, 2000}},
                           {300.0, 0.02, {300, 2000, 300, 1200, 2000, 700, 1900, 400}}};

TEST_F(MotorTest, FollowsAFineIntegration) {
  double errors[3] = {};
  for (int round = 0; round < 3; ++round) {
    world.dt = 0.001 / (1 << round);
    for (const double friction : {0.0, 0.002}) {
      Reference reference;
      reference.friction = friction;
      const Instance motor("motor", world, given({{"friction", friction}}));
      for (const Flight& flight : kFlights) {
        Group g = motor.group(1);
        std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), flight.start);
        double expected = flight.start;
        for (const double command : flight.commands) {
          for (int i = 0; i < std::lround(flight.hold / world.dt); ++i) {
            step(motor, g, command);
            expected = reference.after(expected, command, world.dt);
            errors[round] = std::max(errors[round], std::abs(g.rotor_speed[0] - expected));
          }
        }
      }
    }
    RecordProperty("error" + std::to_string(round), std::to_string(errors[round]));
  }
  // The README's numbers [rad/s], correct to their last digit.
  EXPECT_NEAR(errors[0], 0.185, 0.001);
  EXPECT_NEAR(errors[1], 0.033, 0.001);
  EXPECT_NEAR(errors[2], 0.014, 0.001);
}

TEST_F(MotorTest, KeepsToTheLimitOfTheCurrent) {
  const Instance motor("motor", world, given());
  Group g = motor.group(1);
  // At rest the air exerts no torque, and the rate of a limited current has no slope.
  EXPECT_NEAR(step(motor, g, 2000.0), (0.0055 * 30.0 - 0.002) / 4.92e-6, 1e-6);
  std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), 2000.0);
  const Reference reference;
  const double rate = step(motor, g, 0.0);
  EXPECT_NEAR(rate, (reference.after(2000.0, 0.0, 0.001) - 2000.0) / 0.001, 1e-3 * std::abs(rate));
  EXPECT_LT(rate, -(0.0055 * 30.0) / 4.92e-6);
}

TEST_F(MotorTest, WithoutBrakesIsSlowedByTheAirAlone) {
  const Instance motor("motor", world, given({{"brake", false}, {"friction", 0.0}}));
  Group g = motor.group(1);
  std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), 2000.0);
  double error = 0.0;
  for (int i = 1; i <= 200; ++i) {
    step(motor, g, 0.0);
    // dw/dt = -k_m w^2 / J in closed form.
    const double expected = 2000.0 / (1.0 + 2.8401e-8 / 4.92e-6 * 2000.0 * 0.001 * i);
    error = std::max(error, std::abs(g.rotor_speed[0] - expected));
  }
  EXPECT_LT(error, 0.02);  // second order in dt; measured: 0.013
}

TEST_F(MotorTest, GoesNoFasterThanTheSupplyAllows) {
  const Instance motor("motor", world, given({{"voltage", 10.0}}));
  Group g = motor.group(1);
  for (int i = 0; i < 1000; ++i) step(motor, g, 2200.0);
  const double w = g.rotor_speed[0];
  const double torque = 2.8401e-8 * w * w + 0.002;
  EXPECT_NEAR(0.0055 * w + 0.1 / 0.0055 * torque, 10.0, 1e-9);
}

TEST_F(MotorTest, StaysStableWithLargeSteps) {
  for (const double dt : {0.004, 0.02, 0.1}) {
    world.dt = dt;
    const Instance motor("motor", world, given());
    Group g = motor.group(1);
    for (int i = 0; i < 100; ++i) {
      step(motor, g, 1500.0);
      EXPECT_LT(g.rotor_speed[0], 1500.0 * 1.2);  // a tangent lies above the curve: 14 % at 0.1 s
    }
    EXPECT_NEAR(g.rotor_speed[0], 1500.0, 1e-6);
  }
}

TEST_F(MotorTest, DerivativesAreThoseOfItsDifferences) {
  expect_derivatives({"motor", world, given({{"max_current", 1000.0}}), Call::kApply, {}},
                     {"params", "rotor_command", "rotor_speed"});
}

TEST_F(MotorTest, SaysWhatDoesNotFit) {
  const auto refused = [&](const Parameters& others) {
    return refusal("motor", world, given(others));
  };
  EXPECT_THAT(
      refused({{"max_current", 5.0}}),
      HasSubstr("a motor gives 0.0275 N m at `max_current`, and rotor `rotor0` takes 0.0569"));
  EXPECT_THAT(refused({{"voltage", 5.0}}), HasSubstr("`voltage` is 5 V, and rotor `rotor0` takes"));
  EXPECT_THAT(refused({{"robots", std::vector<std::string>{"quda"}}}),
              HasSubstr("no robot `quda`: there are quad"));
  world.rotors[1].constants[SKYBODY_ROTOR_INERTIA] = 0.0;
  EXPECT_THAT(refused({}), HasSubstr("rotor `rotor1` has an `inertia` of 0"));
}

}  // namespace
}  // namespace skybody::testing
