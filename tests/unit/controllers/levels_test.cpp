// The levels between a trajectory and an attitude: force, acceleration, velocity_tracking,
// integrals and fed-forward rates, by hand calculation and in closed loop.
#include "tests/unit/controllers/flight.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;

class Levels : public ::testing::Test {
 protected:
  Levels() { world.add_quad("quad"); }
  Numbers control(const Instance& instance, const Numbers& input) {
    Group g = instance.group(1);
    g.input = input;
    instance.call(Call::kControl, g);
    return g.output;
  }
  PluginWorld world;
};

constexpr double kWeight = 1.54 * 9.81;

TEST_F(Levels, AForceGivesItsDirectionHeadingAndThePartAlongTheBody) {
  const Instance force("force", world);
  const Numbers out = control(force, {3.0, 0.0, 4.0, 0.0});
  EXPECT_NEAR(out[0], 4.0, 1e-14);  // the body is level
  const double tilt = std::atan2(3.0, 4.0);
  EXPECT_NEAR(out[3], std::sin(0.5 * tilt), 1e-15);  // about +y: towards +x
  EXPECT_NEAR(out[1], std::cos(0.5 * tilt), 1e-15);
  EXPECT_NEAR(control(force, {0.0, 0.0, 5.0, 0.8})[4], std::sin(0.4), 1e-15);
  EXPECT_EQ(control(force, {0.0, 0.0, -5.0, 0.0}), (Numbers{0, 1, 0, 0, 0}));
}

TEST_F(Levels, AForceMayComeOnTopOfTheWeight) {
  const Instance force(
      "force", world,
      {{"adds_weight", true}, {"takes_yaw", false}, {"max_force", Numbers{9, 9, 15}}});
  EXPECT_EQ(force.declared.controller.low, (Numbers{-9, -9, -15}));
  EXPECT_EQ(force.declared.controller.high, (Numbers{9, 9, 15}));
  EXPECT_NEAR(control(force, {0.0, 0.0, 0.0})[0], kWeight, 1e-13);
  const Instance turned("force", world, {{"takes_yaw", false}, {"yaw", 0.6}});
  EXPECT_NEAR(control(turned, {0.0, 0.0, 9.0})[4], std::sin(0.3), 1e-15);
}

TEST_F(Levels, AnAccelerationTakesTheWeightAndItsOwnForce) {
  const Instance acceleration("acceleration", world, {{"max_acceleration_side", 5}});
  Numbers out = control(acceleration, {1.0, -2.0, 0.5, 0.3});
  EXPECT_NEAR(out[0], 1.54, 1e-14);
  EXPECT_NEAR(out[1], -3.08, 1e-14);
  EXPECT_NEAR(out[2], 1.54 * 10.31, 1e-13);
  EXPECT_EQ(out[3], 0.3);
  out = control(acceleration, {30.0, 40.0, 99.0, 0.0});
  EXPECT_NEAR(out[0], 1.54 * 3.0, 1e-14);  // limited in length, not in direction
  EXPECT_NEAR(out[1], 1.54 * 4.0, 1e-14);
  EXPECT_NEAR(out[2], 1.54 * (12.0 + 9.81), 1e-13);
}

TEST_F(Levels, RatesOfTheWishedAttitudeAreAddedInTheBodysAxes) {
  const Instance attitude("attitude", world, {{"feed_forward", true}});
  Numbers out = control(attitude, {9.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3});
  EXPECT_NEAR(out[1], 0.1, 1e-15);
  EXPECT_NEAR(out[3], 0.3, 1e-15);
  // The desired body is rotated by a quarter turn about z: its x axis is the actual body's y axis.
  const double half = std::sqrt(0.5);
  out = control(attitude, {9.0, half, 0.0, 0.0, half, 1.0, 0.0, 0.0});
  EXPECT_NEAR(out[1], 0.0, 1e-15);
  EXPECT_NEAR(out[2], 1.0, 1e-15);
}

TEST_F(Levels, TiltComesFirstWhereItHasPriority) {
  // A tilt of 0.2 rad about y, then a heading of 2 rad: for any heading, the body's z axis moves by
  // the shortest rotation.
  const Instance attitude("attitude", world,
                          {{"error", "tilt_priority"}, {"gain", Numbers{1, 1, 1}}});
  const Quat<double> setpoint = Quat<double>{std::cos(0.1), 0, std::sin(0.1), 0} *
                                Quat<double>{std::cos(1.0), 0, 0, std::sin(1.0)};
  const Numbers out = control(attitude, {9.0, setpoint.w, setpoint.x, setpoint.y, setpoint.z});
  EXPECT_NEAR(out[1], 0.0, 1e-15);
  EXPECT_NEAR(out[2], 2.0 * std::sin(0.1), 1e-15);
  EXPECT_NEAR(out[3], 2.0 * std::sin(1.0), 1e-15);
  const Numbers over = control(attitude, {9.0, 0.0, 0.6, 0.8, 0.0});  // half a turn: v's own axis
  EXPECT_NEAR(over[1], 1.2, 1e-15);
  EXPECT_NEAR(over[2], 1.6, 1e-15);
}

TEST_F(Levels, TheErrorOnSE3IsTheSineOfTheAngle) {
  const Instance attitude("attitude", world, {{"error", "se3"}, {"gain", Numbers{1, 1, 1}}});
  const Numbers out = control(attitude, {9.0, std::cos(1.2), std::sin(1.2), 0.0, 0.0});
  EXPECT_NEAR(out[1], std::sin(2.4), 1e-15);
}

/// Flies a velocity and a yaw rate for `seconds`. @returns the flight at the end
Flight fly_velocity(PluginWorld& world, const Parameters& given, const Numbers& command,
                    double seconds) {
  Chain control(world, {{"velocity_tracking", given},
                        {"acceleration", {}},
                        {"force", {}},
                        {"attitude", {}},
                        {"ctbr", {}}});
  Flight flight(world);
  flight.p = {0, 0, 50};
  control.reset(flight);
  const int steps = static_cast<int>(seconds / world.dt);
  for (int n = 0; n < steps; ++n) flight.step(control.control(flight, command), true);
  return flight;
}

TEST_F(Levels, AVelocityIsReachedWithTheHeadingTurningAtItsRate) {
  const Flight flight = fly_velocity(world, {}, {1.5, -0.5, 0.4, 0.7}, 4.0);
  // Rotor drag, 0.076 1/s, against a gain of 3 1/s.
  EXPECT_NEAR(flight.v.x, 1.5, 0.05);
  EXPECT_NEAR(flight.v.y, -0.5, 0.05);
  EXPECT_NEAR(flight.v.z, 0.4, 0.01);
  EXPECT_NEAR(flight.w.z, 0.7, 0.05);
}

TEST_F(Levels, AnIntegralTakesTheRestOfTheVelocityError) {
  const Flight flight = fly_velocity(world, {{"ki", Numbers{2, 2, 2}}}, {1.5, -0.5, 0.4, 0.0}, 8.0);
  EXPECT_NEAR(flight.v.x, 1.5, 1e-3);
  EXPECT_NEAR(flight.v.y, -0.5, 1e-3);
  EXPECT_NEAR(flight.v.z, 0.4, 1e-3);
}

/// Hovers by `position` with a body 0.2 kg heavier than the controller's model, after an
/// unreachable command for `away` steps. @returns height above the goal over time [m]
std::vector<double> heights(PluginWorld& world, const Parameters& given, int away) {
  Chain control(world, {{"position", given}, {"attitude", {}}, {"ctbr", {}}});
  PluginWorld heavy = world;
  heavy.bodies[0].mass += 0.2;
  Flight flight(heavy);
  control.reset(flight);
  std::vector<double> out;
  for (int n = 0; n < 12000 + away; ++n) {
    const double goal = n < away ? 3.0 : 1.0;
    flight.step(control.control(flight, {0.0, 0.0, goal, 0.0}), true);
    if (n < away) {  // held down
      flight.p = {0, 0, 1};
      flight.v = {0, 0, 0};
    } else {
      out.push_back(flight.p.z - 1.0);
    }
  }
  return out;
}

TEST_F(Levels, AnIntegralCarriesWhatTheControllerDoesNotKnow) {
  // Without an integral, 0.2 kg give an error of g m / (m kp).
  EXPECT_LT(heights(world, {}, 0).back(), -0.1);
  EXPECT_NEAR(heights(world, {{"ki", Numbers{2, 2, 4}}}, 0).back(), 0.0, 2e-3);
}

TEST_F(Levels, AnIntegralDoesNotWindUpWhileTheLimitHolds) {
  // Held down for five seconds 2 m below its goal, where kp alone requests 18 m/s^2 of at most 5.
  const std::vector<double> height = heights(world, {{"ki", Numbers{2, 2, 4}}}, 5000);
  EXPECT_LT(*std::max_element(height.begin(), height.end()), 0.1);
}

TEST_F(Levels, GiveTheBitsOfDoubleInEveryInstructionSet) {
  for (const char* name : {"force", "acceleration", "velocity_tracking"}) {
    expect_same_bits(name, world);
  }
  expect_same_bits("velocity_tracking", world, {{"ki", Numbers{1, 1, 1}}});
  expect_same_bits("force", world, {{"takes_yaw", false}, {"adds_weight", true}});
  expect_same_bits("position", world, {{"ki", Numbers{1, 1, 1}}});
  expect_same_bits("attitude", world, {{"feed_forward", true}, {"error", "tilt_priority"}});
  expect_same_bits("attitude", world, {{"error", "se3"}});
}

TEST_F(Levels, LetANaNThrough) {
  const double nan = kNan;
  EXPECT_TRUE(std::isnan(control(Instance("force", world), {nan, 0, 9, 0})[0]));
  EXPECT_TRUE(std::isnan(control(Instance("force", world), {0, 0, nan, 0})[0]));
  EXPECT_TRUE(std::isnan(control(Instance("force", world), {0, 0, 9, nan})[1]));
  EXPECT_TRUE(std::isnan(control(Instance("acceleration", world), {nan, 0, 0, 0})[0]));
  EXPECT_TRUE(std::isnan(control(Instance("velocity_tracking", world), {0, nan, 0, 0})[1]));
  EXPECT_TRUE(std::isnan(control(Instance("velocity_tracking", world), {0, 0, 0, nan})[3]));
}

}  // namespace
}  // namespace skybody::testing
