// Joints against closed forms, and our kinematics against Simbody's.
#include "core/physics/bodies/kinematics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/physics/test_models.h"
#include "tests/unit/physics/tree_dynamics.h"

namespace skybody::test {
namespace {

constexpr double kG = 9.81;
constexpr auto kRk4 = IntegratorChoice::kRk4;

/// Rotates F's z axis to -y of W, so that a pin at rest has its body's y axis up.
const Quat<double> kHorizontalPin = from_axis_angle(Vec3<double>{1, 0, 0}, kHalfPi);

/// One body on the world by `type`, its centre of mass `length` below the joint.
RobotModel make_pendulum(JointType type, double mass, double length, SymMat3<double> inertia) {
  RobotModel model;
  model.fixed_base = true;
  const bool pin = type == JointType::kPin;
  const Vec3<double> com = pin ? Vec3<double>{0, -length, 0} : Vec3<double>{0, 0, -length};
  model.bodies.push_back(make_body("bob", type, -1, mass, com, inertia));
  if (pin) model.bodies[0].joint.frame_in_parent.rotation = kHorizontalPin;
  return model;
}

Scenario high_up(RobotModel model, double dt = 0.001) {
  Scenario scenario = make_scenario(std::move(model), kRk4, dt);
  scenario.robots[0].pose.position = {0.3, -0.2, 10.0};
  return scenario;
}

/// Arithmetic-geometric mean; a pendulum of amplitude a has the period T_0 / agm(1, cos(a / 2)).
double agm(double a, double b) {
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return a;
}

double pendulum_period(JointType type, int coordinate, SymMat3<double> inertia, double amplitude) {
  Bench bench(high_up(make_pendulum(type, 0.4, 0.7, inertia)));
  bench.state.q[coordinate] = -amplitude;
  return mean_period(upward_crossings(
      bench, [&] { return bench.state.q[coordinate]; }, 12000));
}

TEST(Pin, SmallAndLargeSwingsHaveTheirPeriods) {
  const double inertia = 0.02;
  const double slow = kTwoPi * std::sqrt((inertia + 0.4 * 0.49) / (0.4 * kG * 0.7));
  for (const double amplitude : {0.01, 1.0, 3.0}) {
    // Crossings are interpolated linearly: an error of (w h)^2 / 8 of a step each, far below 1e-7
    // s.
    EXPECT_NEAR(pendulum_period(JointType::kPin, 0, diagonal(0.01, 0.015, inertia), amplitude),
                slow / agm(1.0, std::cos(0.5 * amplitude)), 1e-6)
        << "amplitude " << amplitude;
  }
}

TEST(Universal, SwingsAboutEachAxisWithThatAxisInertia) {
  const SymMat3<double> inertia = diagonal(0.01, 0.016, 0.02);
  for (const double amplitude : {0.01, 1.2}) {
    const double share = agm(1.0, std::cos(0.5 * amplitude));
    EXPECT_NEAR(pendulum_period(JointType::kUniversal, 0, inertia, amplitude),
                kTwoPi * std::sqrt((0.01 + 0.4 * 0.49) / (0.4 * kG * 0.7)) / share, 1e-6);
    EXPECT_NEAR(pendulum_period(JointType::kUniversal, 1, inertia, amplitude),
                kTwoPi * std::sqrt((0.016 + 0.4 * 0.49) / (0.4 * kG * 0.7)) / share, 1e-6);
  }
}

TEST(Ball, ConicalPendulumCirclesAtConstantHeight) {
  const double tilt = 0.6, m = 0.205, length = 1.0, axial = 0.003, transverse = 0.01;
  Bench bench(
      high_up(make_pendulum(JointType::kBall, m, length, diagonal(transverse, transverse, axial))));
  // Conical precession about the vertical: W^2 (A - C) cos(tilt) = m g l, A about the pivot.
  const double rate =
      std::sqrt(m * kG * length / ((transverse + m * length * length - axial) * std::cos(tilt)));
  const Quat<double> rotation = from_axis_angle(Vec3<double>{0, 1, 0}, tilt);
  store(rotation, bench.state.q.data());
  store(rotate_inverse(rotation, Vec3<double>{0, 0, rate}), bench.state.u.data());
  ASSERT_TRUE(bench.run(2000));
  const Vec3<double> bob = rotate(bench.state.bodies[0].rotation, Vec3<double>{0, 0, -length});
  // rk4's phase error: (w h)^5 / 120 per step, 2000 steps.
  EXPECT_NEAR(bob.z, -length * std::cos(tilt), 1e-10);
  EXPECT_NEAR(bob.x, -std::sin(tilt) * length * std::cos(2.0 * rate), 1e-9);
  EXPECT_NEAR(bob.y, -std::sin(tilt) * length * std::sin(2.0 * rate), 1e-9);
}

TEST(DoublePendulum, BothModesHaveTheirFrequencies) {
  const double m1 = 0.3, m2 = 0.2, l1 = 0.4, l2 = 0.35, arm = 0.6, i1 = 0.01, i2 = 0.004;
  // Linearised in absolute angles: M theta'' + K theta = 0.
  const double a = i1 + m1 * l1 * l1 + m2 * arm * arm, b = m2 * arm * l2, d = i2 + m2 * l2 * l2;
  const double k1 = (m1 * l1 + m2 * arm) * kG, k2 = m2 * l2 * kG;
  const double p = a * d - b * b, q = a * k2 + d * k1;
  const double root = std::sqrt(q * q - 4.0 * p * k1 * k2);
  for (const double w2 : {(q - root) / (2.0 * p), (q + root) / (2.0 * p)}) {
    RobotModel model = make_pendulum(JointType::kPin, m1, l1, diagonal(0.01, 0.01, i1));
    model.bodies.push_back(
        make_body("second", JointType::kPin, 0, m2, {0, -l2, 0}, diagonal(0.004, 0.004, i2)));
    model.bodies[1].joint.frame_in_parent.position = {0, -arm, 0};
    Bench bench(high_up(model));
    // Mode shape: (K - w^2 M) theta = 0; the second angle is relative.
    const double first = -1e-4, second = first * (k1 - w2 * a) / (w2 * b);
    bench.state.q = {first, second - first};
    const double period = mean_period(upward_crossings(
        bench, [&] { return bench.state.q[0]; }, 10000));
    // Amplitude 1e-4: nonlinearity a^2 / 16 < 1e-8.
    EXPECT_NEAR(period, kTwoPi / std::sqrt(w2), 1e-6);
  }
}

TEST(Slider, SpringWithDampingDecaysAsItShould) {
  RobotModel model;
  model.fixed_base = true;
  model.bodies.push_back(
      make_body("mass", JointType::kSlider, -1, 0.5, {0, 0, 0}, diagonal(0.01, 0.01, 0.01)));
  Joint& joint = model.bodies[0].joint;
  joint.constants[kJointStiffness] = 40.0;
  joint.constants[kJointRest] = 0.1;
  joint.constants[kJointDamping] = 0.6;
  Bench bench(high_up(model));
  bench.state.q[0] = 0.35;
  ASSERT_TRUE(bench.run(1500));
  const double decay = 0.6, w = std::sqrt(80.0 - decay * decay), t = 1.5;
  const double expected =
      0.1 + 0.25 * std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
  // rk4: (w h)^5 / 120 = 5e-13 per step.
  EXPECT_NEAR(bench.state.q[0], expected, 1e-9);
  EXPECT_NEAR(bench.state.bodies[0].position.x, 0.3 + expected, 1e-9);
}

TEST(Slider, LimitPushesBackAndNeverPulls) {
  RobotModel model;
  model.fixed_base = true;
  model.bodies.push_back(
      make_body("mass", JointType::kSlider, -1, 0.5, {0, 0, 0}, diagonal(0.01, 0.01, 0.01)));
  model.bodies[0].joint.limit = {true, -0.1, 0.2};
  model.bodies[0].joint.constants[kLimitStiffness] = 5000.0;
  model.bodies[0].joint.constants[kLimitDamping] = 3.0;
  Bench bench(high_up(model));
  bench.state.u[0] = 1.0;
  double farthest = 0.0;
  for (int i = 0; i < 400; ++i) {
    ASSERT_TRUE(bench.run(1));
    farthest = std::fmax(farthest, bench.state.q[0]);
  }
  // At most half of the kinetic energy is in the spring: x = v sqrt(m / k) = 0.01 m beyond the
  // bound.
  EXPECT_GT(farthest, 0.2);
  EXPECT_LT(farthest, 0.2101);
  EXPECT_LT(bench.state.u[0], 0.0) << "bounced back";
  EXPECT_GT(bench.state.u[0], -1.0) << "and lost energy";
}

/// A free base with a chain of every joint type, with rotated and offset frames.
RobotModel make_chain() {
  RobotModel model = make_free_body(1.2, {0.02, 0.03, 0.04, 0.001, -0.002, 0.003}, {0.01, 0.02, 0});
  const JointType types[] = {JointType::kPin,    JointType::kUniversal, JointType::kBall,
                             JointType::kSlider, JointType::kWeld,      JointType::kFree};
  const char* names[] = {"pin", "universal", "ball", "slider", "weld", "free"};
  int parent = 0;
  for (const JointType type : types) {
    Body body = make_body(names[parent], type, parent, 0.3, {0.03, -0.02, -0.1},
                          {0.002, 0.0025, 0.003, 1e-4, -2e-4, 1e-4});
    body.joint.frame_in_parent = {{0.1, 0.05, -0.2}, from_rpy(0.3, 0.1, -0.5)};
    body.joint.frame_in_body = {{-0.02, 0.04, 0.06}, from_rpy(-0.6, 0.2, 0.4)};
    model.bodies.push_back(body);
    ++parent;
  }
  return model;
}

void put_random_coordinates(Bench& bench, unsigned seed) {
  const auto next = [&seed] {
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) * (2.0 / 16777216.0) - 1.0;
  };
  for (double& q : bench.state.q) q = next();
  for (double& u : bench.state.u) u = 2.0 * next();
  for (const TreeBody& body : make_tree(bench.world)) {
    normalize_position(body.type, bench.state.q.data() + body.q);
  }
  bench.stepper->update_bodies(bench.state);
}

TEST(Kinematics, AgreesWithSimbodyForEveryJointAndTurnedFrames) {
  Bench bench(high_up(make_chain()));
  const std::unique_ptr<Dynamics> simbody = make_nominal_simbody(bench.world);
  std::vector<BodyState> theirs(bench.world.bodies.size());
  for (unsigned seed = 1; seed <= 50; ++seed) {
    put_random_coordinates(bench, seed);
    simbody->body_states(bench.state.q.data(), bench.state.u.data(), theirs.data());
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      const BodyState &a = bench.state.bodies[i], &b = theirs[i];
      // Seven bodies of some ten roundings each, values of order 10.
      EXPECT_LT(norm(a.position - b.position), 1e-13);
      EXPECT_LT(norm(a.velocity - b.velocity), 1e-13);
      EXPECT_LT(norm(a.angular_velocity - b.angular_velocity), 1e-13);
      const Quat<double> turn = conjugate(a.rotation) * b.rotation;
      EXPECT_NEAR(std::fabs(turn.w), 1.0, 1e-13);
    }
  }
}

TEST(Chain, OfEveryJointTypeKeepsItsEnergy) {
  Bench bench(high_up(make_chain(), 0.0005));
  put_random_coordinates(bench, 7);
  bench.state.q[2] = 20.0;
  bench.stepper->update_bodies(bench.state);
  const auto energy = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
      const MassProperties& mass = bench.world.bodies[i].model->mass;
      const BodyState& b = bench.state.bodies[i];
      sum +=
          kinetic_energy(b, mass) + mass.mass * kG * (b.position + rotate(b.rotation, mass.com)).z;
    }
    return sum;
  };
  const double before = energy();
  ASSERT_TRUE(bench.run(1000));
  // A wrong sign or frame in any joint's coordinates changes the energy; rk4 at 0.5 ms leaves 1e-9.
  EXPECT_NEAR(energy(), before, 1e-7);
}

}  // namespace
}  // namespace skybody::test
