// Stops of joints: they hold, and never add energy, at any step size.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/unit/physics/stepper.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

constexpr double kG = 9.81;
constexpr double kSteps[] = {0.00025, 0.001, 0.002, 0.003, 0.004};
constexpr double kShoulderLimit = 1.9, kElbowLimit = 2.5;

/// A light arm of two joints about y below a heavy base, with the numbers of `firefly_arm`. Its
/// springs are designed for the inertia that a joint moves while the other joint is rigid.
RobotModel arm() {
  RobotModel model = make_free_body(1.612, diagonal(0.0364, 0.0475, 0.0674), {0, 0, -0.0047});
  model.bodies.push_back(make_body("upper_arm", JointType::kPin, 0, 0.09708, {0, 0, -0.1845},
                                   diagonal(2.01e-4, 1.98e-4, 1.43e-5)));
  model.bodies.push_back(make_body("forearm", JointType::kPin, 1, 0.07131, {0, 0, -0.1591},
                                   diagonal(1.47e-4, 1.37e-4, 2.66e-5)));
  const double heights[] = {0.0, -0.105, -0.2};
  for (std::size_t i = 1; i < 3; ++i) {
    Joint& joint = model.bodies[i].joint;
    joint.frame_in_parent = {{0, 0, heights[i]}, from_axis_angle(Vec3<double>{1, 0, 0}, -kHalfPi)};
    joint.frame_in_body.rotation = joint.frame_in_parent.rotation;
    const double inertia = i == 1 ? 0.0101 : 0.0019;
    joint.limit = i == 1 ? JointLimit{true, -kShoulderLimit, kShoulderLimit}
                         : JointLimit{true, 0.0, kElbowLimit};
    joint.constants[kLimitStiffness] = 1e4 * inertia;
    joint.constants[kLimitDamping] = 200.0 * inertia;
  }
  return model;
}

double energy(const Bench& bench) {
  double sum = 0.0;
  for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
    const MassProperties& mass = bench.world.bodies[i].model->mass;
    const BodyState& b = bench.state.bodies[i];
    sum += kinetic_energy(b, mass) + mass.mass * kG * (b.position + rotate(b.rotation, mass.com)).z;
  }
  return sum;
}

struct Outcome {
  double beyond = 0.0;  ///< largest angle beyond the limits [rad]
  double rate = 0.0;    ///< largest rate of a joint [rad/s]
  double gain = 0.0;    ///< largest gain of energy without springs [J]
};

/// Two seconds of a falling vehicle, thrown with a bent arm and a spin about its y axis.
Outcome fly(IntegratorChoice integrator, DynamicsChoice dynamics, double dt, double spin) {
  Scenario scenario = make_scenario(arm(), integrator, dt);
  scenario.stepping.dynamics = dynamics;
  scenario.contact.ground = false;
  scenario.robots[0].pose.position = {0, 0, 100};
  Bench bench(std::move(scenario));
  bench.state.q[7] = -0.5;
  bench.state.q[8] = 1.0;
  bench.state.u[4] = spin;
  bench.stepper->update_bodies(bench.state);
  const double before = energy(bench);
  Outcome out;
  for (int k = 0; k < std::lround(2.0 / dt); ++k) {
    if (!bench.run(1)) return {1e9, 0.0, 1e9};
    const double shoulder = bench.state.q[7], elbow = bench.state.q[8];
    out.beyond = std::fmax(out.beyond, std::fabs(shoulder) - kShoulderLimit);
    out.beyond = std::fmax(out.beyond, std::fmax(-elbow, elbow - kElbowLimit));
    out.rate =
        std::fmax(out.rate, std::fmax(std::fabs(bench.state.u[6]), std::fabs(bench.state.u[7])));
    out.gain = std::fmax(out.gain, energy(bench) - before);
  }
  return out;
}

TEST(JointStops, HoldAndGiveNoEnergyWhateverTheStep) {
  for (const double dt : kSteps) {
    for (const double spin : {3.0, -3.0, 8.0, -8.0, 15.0, -15.0}) {
      const Outcome out = fly(IntegratorChoice::kMidpoint, DynamicsChoice::kTree, dt, spin);
      const std::string where = std::to_string(dt) + " s, " + std::to_string(spin) + " rad/s";
      // docs/urdf.md: u (0.004 s + dt).
      EXPECT_LT(out.beyond, out.rate * (0.004 + dt)) << where;
      // Energy error of midpoint for the swing, of some joules, at 4 ms: 6.5e-5 measured.
      EXPECT_LT(out.gain, 2e-4) << where;
    }
  }
}

TEST(JointStops, HoldWithEveryIntegratorAndBothDynamics) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    for (const DynamicsChoice dynamics : {DynamicsChoice::kTree, DynamicsChoice::kSimbody}) {
      const Outcome out = fly(integrator, dynamics, 0.004, 8.0);
      EXPECT_LT(out.beyond, out.rate * 0.008);
    }
  }
}

/// A stiff undamped stop, a thousand times stiffer than the step can resolve.
TEST(JointStops, OfAnyStiffnessTakeEnergy) {
  for (const double stiffness : {1e2, 1e5, 1e8}) {
    RobotModel model;
    model.fixed_base = true;
    model.bodies.push_back(
        make_body("mass", JointType::kSlider, -1, 0.5, {0, 0, 0}, diagonal(0.01, 0.01, 0.01)));
    model.bodies[0].joint.limit = {true, -0.1, 0.2};
    model.bodies[0].joint.constants[kLimitStiffness] = stiffness;
    Bench bench(make_scenario(std::move(model), IntegratorChoice::kMidpoint, 0.004));
    bench.state.u[0] = 3.0;
    for (int k = 0; k < 1000; ++k) {
      ASSERT_TRUE(bench.run(1));
      const double q = bench.state.q[0], beyond = std::fmax(0.0, std::fmax(q - 0.2, -0.1 - q));
      const double total =
          0.25 * bench.state.u[0] * bench.state.u[0] + 0.5 * stiffness * beyond * beyond;
      ASSERT_LE(total, 0.25 * 9.0 * (1.0 + 1e-12)) << stiffness << ", step " << k;  // rounding
    }
  }
}

}  // namespace
}  // namespace skybody::test
