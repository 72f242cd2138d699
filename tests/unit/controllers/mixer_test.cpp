// mixer: matrices and the pseudo-inverse of six axes, by hand.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using V = Vec3<double>;
using ::testing::HasSubstr;

constexpr double kThrustConstant = 1.9533e-6, kMomentConstant = 2.8401e-8;

/// Eight rotors on the corners of a cube that push across its diagonals, half of them downwards.
PluginWorld cube(double min_speed) {
  PluginWorld world;
  world.add_robot("cube", 0, 0, 1);
  world.add_body(0, "base", -1, SKYBODY_FREE, 1.0, {0.01, 0.01, 0.01});
  world.bodies[0].com[0] = 0.01;  // breaks the symmetry
  // Brescianini and D'Andrea 2016: axes with equal limits of force and torque in all directions.
  const double a = 0.5 + 1.0 / std::sqrt(12.0), b = 0.5 - 1.0 / std::sqrt(12.0),
               c = 1.0 / std::sqrt(3.0);
  const V axes[4] = {{-a, b, c}, {b, a, -c}, {-b, -a, -c}, {a, -b, c}};
  for (int i = 0; i < 8; ++i) {
    const V at{i & 1 ? 0.2 : -0.2, i & 2 ? 0.2 : -0.2, i & 4 ? 0.2 : -0.2};
    world.add_rotor(0, {at.x, at.y, at.z}, 1.0);
    const V& axis = axes[i < 4 ? i : 7 - i];
    SkybodyRotorInfo& rotor = world.rotors.back();
    rotor.axis[0] = axis.x;
    rotor.axis[1] = axis.y;
    rotor.axis[2] = axis.z;
    rotor.min_speed = min_speed;
  }
  return world;
}

std::array<double, 6> wrench(const PluginWorld& world, const std::vector<double>& speeds) {
  V force{0, 0, 0}, moment{0, 0, 0};
  const V com{world.bodies[0].com[0], world.bodies[0].com[1], world.bodies[0].com[2]};
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const SkybodyRotorInfo& r = world.rotors[i];
    const double square = speeds[i] * std::abs(speeds[i]);
    const V axis{r.axis[0], r.axis[1], r.axis[2]};
    const V push = axis * (kThrustConstant * square);
    force += push;
    moment += cross(V{r.position[0], r.position[1], r.position[2]} - com, push);
    moment -= axis * (r.direction * kMomentConstant * square);
  }
  return {force.x, force.y, force.z, moment.x, moment.y, moment.z};
}

std::vector<double> control(const Instance& instance, const std::vector<double>& input) {
  Group g = instance.group(1);
  g.input = input;
  instance.call(Call::kControl, g);
  return g.output;
}

TEST(Mixer, ReversibleRotorsGiveTheWrenchThatIsAskedFor) {
  PluginWorld world = cube(-2246.0);
  const Instance instance("mixer", world, {{"signal", "wrench"}});
  const std::vector<double> u = {3, -2, 9.81, 0.3, -0.2, 0.1};
  const auto got = wrench(world, control(instance, u));
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(got[k], u[k], 1e-12) << k;
}

TEST(Mixer, RefusesAPseudoInverseThatCannotHover) {
  PluginWorld world = cube(0.0);
  EXPECT_THAT(refusal("mixer", world, {{"signal", "wrench"}}),
              HasSubstr("N to hover, and can push 0 to"));
}

TEST(Mixer, MultipliesByTheMatrixAndHoldsToTheRotorsLimits) {
  PluginWorld world;
  world.add_quad("quad");
  const double full = kThrustConstant * 2246.0 * 2246.0;
  const Instance instance("mixer", world,
                          {{"rotors", std::vector<double>{0.25, 1, 0, 0, 0.25, -1, 0, 0, 0.25, 0, 1,
                                                          0, 0.25, 0, -1, 2}}});
  const std::vector<double> speeds = control(instance, {8.0, 0.5, 0.25, -2.0});
  const double thrusts[4] = {2.5, 1.5, 2.25, 0.0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(kThrustConstant * speeds[i] * speeds[i], thrusts[i], 1e-12) << i;
  }
  EXPECT_NEAR(control(instance, {1000.0, 0, 0, 0})[0], std::sqrt(full / kThrustConstant), 1e-9);
}

}  // namespace
}  // namespace skybody::testing
