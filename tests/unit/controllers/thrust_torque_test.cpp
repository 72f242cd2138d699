// Allocation, saturation, the body's lag, the rate PD and ideal rates.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

struct Wrench4 {
  double thrust, x, y, z;
};

/// Wrench of these rotor speeds about the centre of mass, rotor by rotor.
Wrench4 effect(const PluginWorld& world, const std::vector<double>& speed) {
  Wrench4 sum{0, 0, 0, 0};
  for (std::size_t i = 0; i < speed.size(); ++i) {
    const SkybodyRotorInfo& r = world.rotors[i];
    const double f = r.constants[SKYBODY_ROTOR_THRUST_CONSTANT] * speed[i] * speed[i];
    sum.thrust += f * r.axis[2];
    const double arm[3] = {r.position[0] - world.bodies[0].com[0],
                           r.position[1] - world.bodies[0].com[1],
                           r.position[2] - world.bodies[0].com[2]};
    const double reaction = -r.direction * r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] /
                            r.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
    sum.x += f * (arm[1] * r.axis[2] - arm[2] * r.axis[1] + reaction * r.axis[0]);
    sum.y += f * (arm[2] * r.axis[0] - arm[0] * r.axis[2] + reaction * r.axis[1]);
    sum.z += f * (arm[0] * r.axis[1] - arm[1] * r.axis[0] + reaction * r.axis[2]);
  }
  return sum;
}

class ThrustTorqueTest : public ::testing::Test {
 protected:
  ThrustTorqueTest() { world.add_quad("quad"); }
  std::vector<double> run(const Instance& instance, const std::vector<double>& input) {
    Group g = instance.group(1);
    g.input = input;
    instance.call(Call::kControl, g);
    return g.output;
  }
  PluginWorld world;
};

void expect_near(const Wrench4& got, const std::vector<double>& want, double tolerance) {
  EXPECT_NEAR(got.thrust, want[0], tolerance);
  EXPECT_NEAR(got.x, want[1], tolerance);
  EXPECT_NEAR(got.y, want[2], tolerance);
  EXPECT_NEAR(got.z, want[3], tolerance);
}

TEST_F(ThrustTorqueTest, ReachableWrenchesComeOut) {
  world.bodies[0].com[0] = 0.01;  // breaks the symmetry
  const Instance instance("ctbt", world);
  for (const std::vector<double>& u :
       {std::vector<double>{15, 0, 0, 0}, {15, 0.3, -0.2, 0.02}, {25, -0.5, 0.4, -0.03}}) {
    expect_near(effect(world, run(instance, u)), u, 1e-12);
  }
}

TEST_F(ThrustTorqueTest, WhateverTheRotorsCanDoComesOut) {
  world.bodies[0].com[0] = 0.01;
  const Instance instance("ctbt", world);
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> speed(0.0, 1.0);
  for (int i = 0; i < 10000; ++i) {
    std::vector<double> wanted(4);
    for (double& w : wanted) w = 2246.0 * std::sqrt(speed(generator));  // thrusts are uniform
    const Wrench4 u = effect(world, wanted);
    const std::vector<double> got = run(instance, {u.thrust, u.x, u.y, u.z});
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(got[k], wanted[k], 1e-6) << i;
  }
}

TEST_F(ThrustTorqueTest, WhatIsCutChangesWithoutJumps) {
  const Instance instance("ctbt", world);
  std::mt19937_64 generator(8);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  const auto thrusts = [&](const std::vector<double>& u) {
    std::vector<double> f = run(instance, u);
    for (double& w : f) w = w * w * 1.9533e-6;
    return f;
  };
  for (int i = 0; i < 300; ++i) {
    // Along a line through commands whose roll and pitch torques alone are within limits.
    std::vector<double> from(4), to(4);
    for (std::vector<double>* u : {&from, &to}) {
      *u = {18.0 + 20.0 * draw(generator), 0.6 * draw(generator), 0.5 * draw(generator),
            0.5 * draw(generator)};
    }
    std::vector<double> last = thrusts(from);
    for (int k = 1; k <= 200; ++k) {
      std::vector<double> u(4);
      for (std::size_t c = 0; c < 4; ++c) u[c] = from[c] + (to[c] - from[c]) * k / 200.0;
      const std::vector<double> f = thrusts(u);
      // The command moves by at most 0.2 N of thrust and 0.05 N of each torque per step.
      for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(f[c], last[c], 1.0) << i << " at " << k;
      last = f;
    }
  }
}

TEST(Allocation, WorksForSixTiltedRotors) {
  PluginWorld world;
  world.add_robot("hexa", 0, 0, 1);
  world.add_body(0, "base", -1, 1, 1.5, {0.03, 0.04, 0.06});
  for (int i = 0; i < 6; ++i) {
    const double a = 1.0471975511965976 * i;
    world.add_rotor(0, {0.215 * std::cos(a), 0.215 * std::sin(a), 0.05}, i % 2 == 0 ? 1.0 : -1.0);
    double* axis = world.rotors.back().axis;
    const double s = i % 2 == 0 ? 0.2 : -0.2;
    axis[0] = -s * std::sin(a);
    axis[1] = s * std::cos(a);
    axis[2] = std::sqrt(1.0 - s * s);
  }
  const Instance instance("ctbt", world);
  Group g = instance.group(1);
  g.input = {20.0, 0.4, -0.3, 0.1};
  instance.call(Call::kControl, g);
  expect_near(effect(world, g.output), g.input, 1e-12);
}

TEST_F(ThrustTorqueTest, YawGivesWayFirst) {
  const Instance instance("ctbt", world);
  const Wrench4 got = effect(world, run(instance, {15.0, 0.5, 0.0, 10.0}));
  EXPECT_NEAR(got.thrust, 15.0, 1e-12);
  EXPECT_NEAR(got.x, 0.5, 1e-12);
  EXPECT_NEAR(got.y, 0.0, 1e-12);
  EXPECT_GT(got.z, 0.01);
  EXPECT_LT(got.z, 1.0);
}

TEST_F(ThrustTorqueTest, ThrustGivesWayToRollAndPitch) {
  const Instance instance("ctbt", world);
  const Wrench4 low = effect(world, run(instance, {0.0, 1.0, 0.0, 0.0}));
  EXPECT_NEAR(low.x, 1.0, 1e-12);
  EXPECT_NEAR(low.thrust, 1.0 / 0.127, 1e-12);  // two rotors at rest, least possible thrust
  const double most = instance.declared.controller.high[0];
  const Wrench4 high = effect(world, run(instance, {most, 1.0, 0.0, 0.0}));
  EXPECT_NEAR(high.x, 1.0, 1e-12);
  EXPECT_NEAR(high.thrust, most - 1.0 / 0.127, 1e-11);
}

TEST_F(ThrustTorqueTest, TooMuchRollAndPitchIsScaledInItsDirection) {
  const Instance instance("ctbt", world);
  const Wrench4 got = effect(world, run(instance, {15.0, 30.0, 20.0, 0.0}));
  EXPECT_NEAR(got.y / got.x, 20.0 / 30.0, 1e-12);
  EXPECT_NEAR(got.z, 0.0, 1e-12);
  const std::vector<double> speed = run(instance, {15.0, 30.0, 20.0, 5.0});
  EXPECT_NEAR(*std::max_element(speed.begin(), speed.end()), 2246.0, 1e-6);
  EXPECT_NEAR(*std::min_element(speed.begin(), speed.end()), 0.0, 1e-3);
}

TEST_F(ThrustTorqueTest, RotorsStayWithinTheirLimits) {
  const Instance instance("ctbt", world);
  std::mt19937_64 generator(3);
  Group g = instance.group(1);
  for (int i = 0; i < 1000; ++i) {
    scatter(g, instance.declared, generator);
    for (double& x : g.input) x *= 3.0;
    instance.call(Call::kControl, g);
    for (const double w : g.output) {
      EXPECT_GE(w, 0.0);
      EXPECT_LE(w, 2246.0 * (1.0 + 1e-12));
    }
  }
}

TEST_F(ThrustTorqueTest, UnreachableTorqueIsRefused) {
  for (auto& r : world.rotors) r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] = 0.0;
  EXPECT_THAT(refusal("ctbt", world, {}), HasSubstr("cannot give yaw torque independently"));
  PluginWorld line;
  line.add_robot("line", 0, 0, 1);
  line.add_body(0, "base", -1, 1, 1.0, {1, 1, 1});
  for (int i = 0; i < 4; ++i)
    line.add_rotor(0, {0.1 * i - 0.15, 0.0, 0.0}, i % 2 == 0 ? 1.0 : -1.0);
  EXPECT_THAT(refusal("ctbt", line, {}), HasSubstr("cannot give roll torque"));
  line.rotors.pop_back();
  line.robots[0].rotor_count = 3;
  EXPECT_THAT(refusal("ctbt", line, {}),
              HasSubstr("has 3 rotors; ctbt needs 4 or more: use controller `srt`"));
}

TEST_F(ThrustTorqueTest, BodyLagFollowsEquationTwo) {
  const Instance instance(
      "ctbt", world, {{"apply", "body"}, {"time_constant_up", 0.02}, {"time_constant_down", 0.05}});
  ASSERT_EQ(instance.declared.controller.sites.size(), 1u);
  EXPECT_TRUE(instance.declared.controller.sites[0].at_com);
  EXPECT_FALSE(instance.declared.controller.sites[0].world_axes);
  Group g = instance.group(1);
  g.input = {20.0, 0.5, -0.4, 0.05};
  for (int n = 1; n <= 40; ++n) {
    instance.call(Call::kControl, g);
    const double share = 1.0 - std::exp(-0.001 * n / 0.02);
    EXPECT_NEAR(g.output[2], 20.0 * share, 1e-13);
    EXPECT_NEAR(g.output[4], -0.4 * share, 1e-14);
  }
  const double from = g.output[2];
  g.input = {0.0, 0.0, 0.0, 0.0};
  instance.call(Call::kControl, g);
  EXPECT_NEAR(g.output[2], from * std::exp(-0.001 / 0.05), 1e-13);
  EXPECT_EQ(g.output[0], 0.0);
}

TEST_F(ThrustTorqueTest, BodyLagIsTheRotorsMeanUnlessGivenAndStartsWhereTheyAre) {
  const Instance instance("ctbt", world, {{"apply", "body"}});
  Group g = instance.group(1);
  for (int i = 0; i < 4; ++i) {
    g.params[static_cast<std::size_t>(world.rotors[static_cast<std::size_t>(i)].first_param +
                                      SKYBODY_ROTOR_TAU_DOWN)] = 0.04;
    g.rotor_speed[static_cast<std::size_t>(i)] = 1400.0;
  }
  instance.call(Call::kReset, g);
  g.input = {0.0, 0.0, 0.0, 0.0};
  instance.call(Call::kControl, g);
  EXPECT_NEAR(g.output[2], 4.0 * 1.9533e-6 * 1400.0 * 1400.0 * std::exp(-0.001 / 0.04), 1e-12);
}

TEST_F(ThrustTorqueTest, IdealRatesAreReachedInOnePhysicsStep) {
  const Instance instance("ctbr", world, {{"apply", "body"}, {"pd", false}});
  Group g = instance.group(1);
  double w[3] = {1.0, -2.0, 0.5};
  for (int k = 0; k < 3; ++k) g.bodies[static_cast<std::size_t>(10 + k)] = w[k];
  g.input = {12.0, -3.0, 4.0, 1.0};
  instance.call(Call::kControl, g);
  EXPECT_EQ(g.output[2], 12.0);
  const double j[3] = {0.0147209, 0.0169101, 0.029448};
  const double gyro[3] = {w[1] * j[2] * w[2] - w[2] * j[1] * w[1],
                          w[2] * j[0] * w[0] - w[0] * j[2] * w[2],
                          w[0] * j[1] * w[1] - w[1] * j[0] * w[0]};
  for (int k = 0; k < 3; ++k) {  // Euler's equation, one explicit step
    const double next = w[k] + 0.001 * (g.output[static_cast<std::size_t>(3 + k)] - gyro[k]) / j[k];
    EXPECT_NEAR(next, g.input[static_cast<std::size_t>(1 + k)], 1e-13);
  }
}

TEST_F(ThrustTorqueTest, RatePdScalesWithInertiaAndItsGainsArePerEnvironment) {
  const Instance instance("ctbr", world, {{"kd", std::vector<double>{0, 0, 0}}});
  Group g = instance.group(1);
  g.input = {15.0, 0.5, 0.0, 0.0};
  instance.call(Call::kControl, g);
  EXPECT_NEAR(effect(world, g.output).x, 0.0147209 * 20.0 * 0.5, 1e-12);
  g.params[static_cast<std::size_t>(instance.env_param("kp"))] = 30.0;
  instance.call(Call::kControl, g);
  EXPECT_NEAR(effect(world, g.output).x, 0.0147209 * 30.0 * 0.5, 1e-12);
}

TEST_F(ThrustTorqueTest, DerivativeOpposesAngularAcceleration) {
  const Instance instance(
      "ctbr", world, {{"kp", std::vector<double>{0, 0, 0}}, {"kd", std::vector<double>{2, 2, 2}}});
  Group g = instance.group(1);
  instance.call(Call::kReset, g);
  g.input = {15.0, 0.0, 0.0, 0.0};
  g.bodies[10] = 0.01;  // 10 rad/s^2 over one step
  instance.call(Call::kControl, g);
  EXPECT_NEAR(effect(world, g.output).x, -0.0147209 * 2.0 * 10.0 * (1.0 - std::exp(-0.2)), 1e-12);
}

}  // namespace
}  // namespace skybody::testing
