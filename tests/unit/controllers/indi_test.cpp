// indi in closed loop with one rigid body, and the inputs that it refuses.
// tests/oracle/test_indi.py has a second implementation of its law.
#include <limits>

#include "tests/unit/controllers/flight.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using V = Vec3<double>;
using ::testing::HasSubstr;

class IndiTest : public ::testing::Test {
 protected:
  IndiTest() { world.add_quad("quad"); }

  static std::vector<double> stand(const V& place, double yaw = 0.0) {
    return trajectory_of(standing_at(place, yaw));
  }

  /// Flies for `seconds` with commands that depend on time. @returns the largest error(t) of the
  /// last second
  template <class Command, class Error>
  double fly(const Instance& instance, Flight& flight, double seconds, Command&& command,
             Error&& error) const {
    Group g = instance.group(1);
    flight.show(g);
    instance.call(Call::kReset, g);
    const int period = instance.declared.period, count = static_cast<int>(seconds / world.dt);
    double most = 0.0;
    for (int n = 0; n < count; ++n) {
      flight.show(g);
      g.physics_step[0] = static_cast<std::uint64_t>(n);
      if (n % period == 0) {
        g.input = command(n * world.dt);
        instance.call(Call::kControl, g);
      }
      flight.step(g.output, true);
      if (n + 1000 >= count) most = std::fmax(most, error((n + 1) * world.dt));
    }
    return most;
  }

  PluginWorld world;
};

TEST_F(IndiTest, GivesTheBitsOfDouble) {
  for (const char* signal : {"trajectory", "attitude", "ctbr"}) {
    expect_same_bits("indi", world, {{"signal", signal}});
  }
  expect_same_bits("indi", world, {{"signal", "attitude"}, {"feed_forward", true}});
}

TEST_F(IndiTest, HoldsStillInAConstantForceAndMoment) {
  const Instance instance("indi", world);
  Flight flight(world);
  flight.spins = true;
  flight.other_force = {4.0, -3.0, 2.0};
  flight.other_torque = {0.1, -0.2, 0.02};
  const V place{0.3, -0.2, 1.5};
  const double error = fly(
      instance, flight, 8.0, [&](double) { return stand(place, 0.5); },
      [&](double) { return norm(flight.p - place); });
  // Loops of 2.5 rad/s and more leave exp(-17) of 0.6 m; a PD would be off by 5 N / (1.54 kg 8).
  EXPECT_LT(error, 1e-6);
  EXPECT_NEAR(norm(flight.w), 0.0, 1e-6);
}

TEST_F(IndiTest, HoldsStillWithAWeakRotorAndAWrongMass) {
  const Instance instance("indi", world);
  PluginWorld heavy = world;
  heavy.bodies[0].mass *= 1.2;
  Flight flight(heavy);
  flight.spins = true;
  flight.weak_share = 0.8;
  const V place{0.0, 0.0, 1.0};
  const double error = fly(
      instance, flight, 8.0, [&](double) { return stand(place); },
      [&](double) { return norm(flight.p - place); });
  EXPECT_LT(error, 1e-6);
}

TEST_F(IndiTest, FollowsAQuickCircleToMillimetres) {
  const Instance instance("indi", world);
  Flight flight(world);
  flight.spins = true;
  const auto turn = [](double t) {
    const double c = std::cos(2.0 * t), s = std::sin(2.0 * t);  // 2 m, 4 m/s, 8 m/s^2
    ReferencePoint<double> point = standing_at({2 * c, 2 * s, 1}, 0.4 * std::sin(t));
    point.velocity = {-4 * s, 4 * c, 0};
    point.acceleration = {-8 * c, -8 * s, 0};
    point.jerk = {16 * s, -16 * c, 0};
    point.snap = {32 * c, 32 * s, 0};
    point.yaw_rate = 0.4 * std::cos(t);
    return point;
  };
  flight.p = {2, 0, 1};
  flight.v = {0, 4, 0};
  const double error = fly(
      instance, flight, 8.0, [&](double t) { return trajectory_of(turn(t)); },
      [&](double t) { return norm(flight.p - turn(t).position); });
  // Commands are held for 2 ms and reach the rotors with a lag. The yaw acceleration is not part of
  // a trajectory and therefore not fed forward.
  EXPECT_LT(error, 8e-3);
}

TEST_F(IndiTest, TakesAttitudesAndRates) {
  const Instance attitude("indi", world, {{"signal", "attitude"}});
  Flight flight(world);
  flight.spins = true;
  flight.other_torque = {0.05, 0.1, -0.02};
  const Quat<double> setpoint = from_rpy(0.3, -0.2, 1.0);
  const double turn = fly(
      attitude, flight, 6.0,
      [&](double) {
        return std::vector<double>{15.0, setpoint.w, setpoint.x, setpoint.y, setpoint.z};
      },
      [&](double) {
        const Quat<double> left = conjugate(flight.q) * setpoint;
        return norm(V{left.x, left.y, left.z});
      });
  // It falls ever faster, and the drag of its rotors turns it: the filter follows with a delay of
  // 7.5 ms.
  EXPECT_LT(turn, 1e-4);

  const Instance rates("indi", world, {{"signal", "ctbr"}});
  Flight spin(world);
  spin.spins = true;
  spin.other_torque = {0.05, 0.1, -0.02};
  const double rate = fly(
      rates, spin, 4.0,
      [&](double) {
        return std::vector<double>{15.0, 0.5, -0.4, 1.5};
      },
      [&](double) {
        return norm(spin.w - V{0.5, -0.4, 1.5});
      });
  // The air's moment turns with the body, too.
  EXPECT_LT(rate, 1e-2);
}

TEST_F(IndiTest, ComesBackFromUpsideDown) {
  const Instance instance("indi", world);
  Flight flight(world);
  flight.spins = true;
  flight.q = {0.0, 1.0, 0.0, 0.0};
  flight.p = {0.0, 0.0, 10.0};
  double lowest = 10.0;
  const double error = fly(
      instance, flight, 8.0,
      [&](double) {
        lowest = std::fmin(lowest, flight.p.z);
        return stand({0, 0, 10});
      },
      [&](double) {
        return norm(flight.p - V{0, 0, 10});
      });
  EXPECT_LT(error, 1e-4);
  EXPECT_GT(lowest, 5.0);
}

TEST_F(IndiTest, AtRestWithoutThrustTheRotorsStandStill) {
  const Instance instance("indi", world, {{"signal", "ctbr"}});
  Group g = instance.group(1);
  instance.call(Call::kReset, g);
  g.input = {0.0, 0.0, 0.0, 0.0};
  instance.call(Call::kControl, g);
  EXPECT_EQ(g.output, std::vector<double>(4, 0.0));
  g.input[0] = -5.0;
  instance.call(Call::kControl, g);
  EXPECT_EQ(g.output, std::vector<double>(4, 0.0));
}

TEST_F(IndiTest, ASavedFlightGoesOnWithTheSameBits) {
  const Instance instance("indi", world);
  std::mt19937_64 generator(5);
  Group g = instance.group(1);
  for (int n = 0; n < 20; ++n) {
    scatter(g, instance.declared, generator);
    g.physics_step[0] = static_cast<std::uint64_t>(2 * n);
    instance.call(n == 0 ? Call::kReset : Call::kControl, g);
  }
  Group saved = g;
  instance.call(Call::kControl, g);
  PluginWorld twin;
  twin.add_quad("quad");
  const Instance other("indi", twin);
  other.call(Call::kControl, saved);
  EXPECT_TRUE(g.same_bits(saved));
}

TEST_F(IndiTest, ANaNReferenceIsPassedOnAndLeavesNoTrace) {
  const Instance instance("indi", world);
  Group g = instance.group(1);
  for (double& w : g.rotor_speed) w = 1300.0;
  g.physics_step[0] = 2;
  Group other = g;
  g.input = other.input = stand({0.5, 0.0, 1.0});
  g.input[0] = std::numeric_limits<double>::quiet_NaN();
  instance.call(Call::kControl, g);
  for (const double w : g.output) EXPECT_TRUE(std::isnan(w));
  EXPECT_FALSE(std::isnan(g.buffer[4]));
  // From here on the kept state is motion only, except the requested reaction before the NaN.
  other.input = stand({0.0, 0.0, 1.0});
  instance.call(Call::kControl, other);
  g.input = other.input;
  instance.call(Call::kControl, g);
  instance.call(Call::kControl, other);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(g.output[i], other.output[i], 1e-9);
}

TEST_F(IndiTest, DefaultGainsFollowTheRotorsLagAndGivenOnesDoNot) {
  const Instance plain("indi", world, {{"signal", "ctbr"}});
  for (auto& r : world.rotors) {
    r.constants[SKYBODY_ROTOR_TAU_UP] = r.constants[SKYBODY_ROTOR_TAU_DOWN] = 0.1;
  }
  const Instance slow("indi", world, {{"signal", "ctbr"}});
  const Instance given("indi", world,
                       {{"signal", "ctbr"}, {"rate_gain", std::vector<double>{24, 24, 10}}});
  const auto roll = [&](const Instance& instance) {
    Group g = instance.group(1);
    g.input = {15.0, 0.1, 0.0, 0.0};
    instance.call(Call::kControl, g);
    return g.output[0] * g.output[0] - g.output[1] * g.output[1];
  };
  EXPECT_NEAR(roll(slow) / roll(plain), 0.5 / (0.1 * 24.0), 1e-12);
  EXPECT_NEAR(roll(given) / roll(plain), 1.0, 1e-12);
}

TEST_F(IndiTest, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("indi", world, {{"cutoff", 300.0}}),
              HasSubstr("`cutoff` 300 Hz is too high for 0.002 s"));
  EXPECT_THAT(refusal("indi", world, {{"measured", "imu"}}), HasSubstr("imu"));
  EXPECT_THAT(refusal("indi", world, {{"max_acceleration_down", 9.5}}),
              HasSubstr("`max_acceleration_down` 9.5 would leave no thrust to steer with"));
  EXPECT_THAT(refusal("indi", world, {{"position_min", std::vector<double>{6, 0, 0}}}),
              HasSubstr("`position_min[0]` 6 is not below `position_max[0]` 5"));
  PluginWorld bare;
  bare.add_robot("car", 0, 0, 0);
  bare.add_body(0, "chassis", -1, 1, 1.0, {1, 1, 1});
  EXPECT_THAT(refusal("indi", bare, {}), HasSubstr("robot `car` has no rotors"));
}

}  // namespace
}  // namespace skybody::testing
