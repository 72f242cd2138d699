// `dynamics: tree` on one free body against Simbody, and the worlds that it accepts.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/math/inertia.h"
#include "core/base/math/random.h"
#include "core/model/located_error.h"
#include "core/physics/bodies/kinematics.h"
#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/tree_dynamics.h"

namespace skybody::test {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Random<double> random_numbers(std::uint64_t episode) {
  return {RandomKey{2026, 7}, episode, 0, derive_stream("free_body_test")};
}

void put_mass(const World& world, const MassProperties& mass, std::vector<double>& params) {
  double* p = params.data() + world.layout.body_params[0];
  const SymMat3<double>& i = mass.inertia;
  const double values[] = {mass.mass, mass.com.x, mass.com.y, mass.com.z, i.xx,
                           i.yy,      i.zz,       i.xy,       i.xz,       i.yz};
  std::memcpy(p, values, sizeof(values));
}

TEST(FreeBody, HasTheAccelerationsThatSimbodyFinds) {
  const World world(make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.01))));
  const std::unique_ptr<Dynamics> tree = make_tree_dynamics(world);
  const std::unique_ptr<Dynamics> simbody = make_nominal_simbody(world);
  std::vector<double> params = nominal_params(world);
  for (std::uint64_t k = 0; k < 10000; ++k) {
    Random<double> random = random_numbers(k);
    const MassProperties mass = random_mass(random);
    put_mass(world, mass, params);
    double q[7], u[6], ours[6], theirs[6];
    store(in_cube(random, 10.0), q);
    const Quat<double> turn = random.quaternion();
    const double length = random.uniform(0.5, 2.0);  // as between an integrator's stages
    store(Quat<double>{turn.w * length, turn.x * length, turn.y * length, turn.z * length}, q + 3);
    store(in_cube(random, 10.0), u);
    store(in_cube(random, 20.0), u + 3);
    const double load = mass.mass * 20.0, size = norm(mass.com) + 0.1;
    const SpatialForce<double> force{in_cube(random, load * size), in_cube(random, load)};
    double joint_forces[6];
    store(in_cube(random, load), joint_forces);
    store(in_cube(random, load * size), joint_forces + 3);

    for (Dynamics* dynamics : {tree.get(), simbody.get()}) dynamics->set_params(params.data());
    tree->accelerations(q, u, &force, joint_forces, ours);
    simbody->accelerations(q, u, &force, joint_forces, theirs);

    // Both do some hundred operations on terms of this size. Simbody solves with the inertia about
    // the origin, in which the smallest central moment loses `lost` of its digits.
    const Vec3<double> moments = eigenvalues(mass.inertia);
    const double offset = norm(mass.com), about_origin = moments.z + mass.mass * offset * offset;
    const double lost = about_origin / moments.x;
    const double spin = squared_norm(load_vec3(u + 3));
    const double forces = norm(force.force) + norm(load_vec3(joint_forces));
    const double turning = norm(force.moment) + norm(load_vec3(joint_forces + 3)) +
                           offset * forces + about_origin * spin;
    const double angular_bound = 100.0 * kEpsilon * lost * turning / moments.x;
    const double linear_bound =
        offset * angular_bound + 100.0 * kEpsilon * (forces / mass.mass + offset * spin);
    EXPECT_LT(norm(load_vec3(ours + 3) - load_vec3(theirs + 3)), angular_bound) << k;
    EXPECT_LT(norm(load_vec3(ours) - load_vec3(theirs)), linear_bound) << k;
  }
}

/// All forces on a single body, the centre of mass away from the origin, rotated axes.
Scenario vehicle(IntegratorChoice integrator, DynamicsChoice dynamics) {
  RobotModel model = make_vehicle(qdrone2());
  model.bodies[0].mass.com = {0.01, -0.005, 0.02};
  model.bodies[0].mass.inertia.xy = 5e-4;
  model.bodies[0].mass.inertia.yz = -8e-4;
  for (Rotor& rotor : model.rotors) {
    rotor.constants[kDragConstant] = 2e-5;
    rotor.constants[kRollingMomentConstant] = 1e-6;
    rotor.constants[kRotorInertia] = 5e-6;
  }
  Scenario scenario = make_scenario(std::move(model), integrator);
  scenario.stepping.dynamics = dynamics;
  scenario.robots[0].constants = {0.1, -0.2, 0.05, 0.001, 0.002, -0.001};
  return scenario;
}

/// The largest difference between two motions [m, rad, m/s, rad/s].
double difference(const BodyState& a, const BodyState& b) {
  double most = norm(a.position - b.position);
  most = std::fmax(most, norm(a.velocity - b.velocity));
  most = std::fmax(most, norm(a.angular_velocity - b.angular_velocity));
  const Quat<double> turn = conjugate(a.rotation) * b.rotation;
  return std::fmax(most, 2.0 * norm(Vec3<double>{turn.x, turn.y, turn.z}));
}

TEST(FreeBody, TumblesLikeSimbodysForASecond) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Bench tree(vehicle(integrator, DynamicsChoice::kTree));
    Bench simbody(vehicle(integrator, DynamicsChoice::kSimbody));
    for (Bench* bench : {&tree, &simbody}) {
      bench->state.q[2] = 50.0;
      bench->state.u = {3.0, -1.0, 0.5, 4.0, -6.0, 2.0};
      bench->state.rotor_speed.assign(4, 500.0);
      bench->state.rotor_command = {1500.0, 1200.0, 1450.0, 1400.0};
      ASSERT_TRUE(bench->run(1000));
    }
    EXPECT_GT(norm(tree.state.bodies[0].angular_velocity), 1.0) << "still tumbling";
    // 1000 steps, each of which rounds a height of 50 m to 7e-15 m.
    EXPECT_LT(difference(tree.state.bodies[0], simbody.state.bodies[0]), 1e-11);
  }
}

TEST(FreeBody, TakesOffLandsAndBouncesLikeSimbodys) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Bench tree(vehicle(integrator, DynamicsChoice::kTree));
    Bench simbody(vehicle(integrator, DynamicsChoice::kSimbody));
    double highest = 0.0, fastest_landing = 0.0, fastest_bounce = 0.0, most = 0.0;
    for (Bench* bench : {&tree, &simbody}) bench->state.q[2] = clearance(qdrone2());
    for (int i = 0; i < 2000; ++i) {
      for (Bench* bench : {&tree, &simbody}) {
        bench->state.rotor_command.assign(4, i < 600 ? 1550.0 : 900.0);
        ASSERT_TRUE(bench->run(1));
      }
      const double z = tree.state.q[2], rise = tree.state.u[2];
      highest = std::fmax(highest, z);
      fastest_landing = std::fmin(fastest_landing, rise);
      if (fastest_landing < -1.0) fastest_bounce = std::fmax(fastest_bounce, rise);
      most = std::fmax(most, difference(tree.state.bodies[0], simbody.state.bodies[0]));
    }
    EXPECT_GT(highest, 0.3) << "took off";
    EXPECT_LT(fastest_landing, -1.0) << "came down";
    EXPECT_GT(fastest_bounce, 0.05) << "bounced";
    // Before touch-down 2000 roundings of 1e-16 each. Then the ground, with a natural frequency of
    // some 100 rad/s, turns differences of position into some hundred times larger ones of
    // velocity, at each of a few bounces.
    EXPECT_LT(most, 1e-9);
  }
}

TEST(FreeBody, DrivenBaseIsNotAcceleratedByForces) {
  for (const DynamicsChoice dynamics : {DynamicsChoice::kTree, DynamicsChoice::kSimbody}) {
    Bench bench(vehicle(IntegratorChoice::kRk4, dynamics),
                [](WorldPlan& plan) { plan.drives = {DriveKind::kVelocity}; });
    bench.state.q[2] = 5.0;
    bench.state.drive[0] = 1.5;
    bench.state.rotor_command.assign(4, 2000.0);
    ASSERT_TRUE(bench.run(1000));
    EXPECT_NEAR(bench.state.q[0], 1.5, 1e-12);
    EXPECT_EQ(bench.state.q[2], 5.0);
    EXPECT_EQ(bench.state.u[0], 1.5);
  }
}

bool same_bits(const LaneState& a, const LaneState& b) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0;
  };
  return same(a.q, b.q) && same(a.u, b.u) && same(a.rotor_speed, b.rotor_speed) &&
         std::memcmp(a.bodies.data(), b.bodies.data(), a.bodies.size() * sizeof(BodyState)) == 0;
}

TEST(FreeBody, ResultsDoNotDependOnWhatTheStepperSawBefore) {
  Bench a(vehicle(IntegratorChoice::kRk4, DynamicsChoice::kTree));
  Bench b(vehicle(IntegratorChoice::kRk4, DynamicsChoice::kTree));
  a.state.q[2] = 3.0;
  a.state.rotor_command = {1500.0, 1200.0, 1450.0, 1400.0};
  ASSERT_TRUE(a.run(100));
  const LaneState saved = a.state;
  ASSERT_TRUE(a.run(100));
  // In between, b serves another environment, with other masses, then with invalid masses, then
  // with a NaN state.
  b.param("robots.r.links.base.mass") = 3.0;
  b.param("robots.r.links.base.com[1]") = 0.1;
  ASSERT_TRUE(b.run(37));
  b.param("robots.r.links.base.inertia[0]") = 1.0;
  EXPECT_FALSE(b.run(1));
  b.state = saved;
  b.state.u[0] = kNan;
  EXPECT_FALSE(b.run(1));
  b.state = saved;
  ASSERT_TRUE(b.run(100));
  EXPECT_TRUE(same_bits(a.state, b.state));
}

std::string message_of(Dynamics& dynamics, const std::vector<double>& params) {
  try {
    dynamics.set_params(params.data());
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(FreeBody, RefusesDrawnMassesAsSimbodysDoes) {
  const World world(make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.01))));
  const std::unique_ptr<Dynamics> tree = make_tree_dynamics(world);
  const std::unique_ptr<Dynamics> simbody = make_nominal_simbody(world);
  const auto expect_same_refusal = [&](const char* path, double value) {
    std::vector<double> params = nominal_params(world);
    params[world.layout.find_param(std::string("robots.r.links.base.") + path)] = value;
    const std::string message = message_of(*tree, params);
    EXPECT_NE(message.find("body 'base'"), std::string::npos) << path << ": " << message;
    EXPECT_EQ(message, message_of(*simbody, params)) << path;
    EXPECT_EQ(message, message_of(*tree, params)) << "the second time as well";
    EXPECT_EQ(message_of(*tree, nominal_params(world)), "") << "and goes on with good ones";
  };
  expect_same_refusal("mass", 0.0);
  expect_same_refusal("mass", kNan);
  expect_same_refusal("com[2]", kInfinity);
  expect_same_refusal("inertia[1]", -0.01);
  expect_same_refusal("inertia[2]", 0.021);
  expect_same_refusal("inertia[4]", kNan);
}

TEST(FreeBody, OfImpossibleNominalMassIsRefusedWhenMade) {
  const World world(make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.03))));
  EXPECT_THROW(make_tree_dynamics(world), Error);
}

/// One step of the spinning vehicle on `stepper`.
LaneState step_once(const World& world, std::unique_ptr<Stepper> stepper) {
  LaneState state;
  write_default_state(world, state);
  state.q[2] = 2.0;
  for (std::size_t i = 3; i < state.u.size(); ++i) state.u[i] = 1.0 + 0.7 * i;
  EXPECT_TRUE(stepper->advance(state));
  return state;
}

TEST(Auto, TakesTreeWhereItCan) {
  const World one(vehicle(IntegratorChoice::kRk4, DynamicsChoice::kAuto));
  const LaneState by_auto = step_once(one, make_stepper(one));
  const LaneState by_tree = step_once(one, make_tree_stepper(one));
  const LaneState by_simbody = step_once(one, make_simbody_stepper(one));
  EXPECT_TRUE(same_bits(by_auto, by_tree));
  EXPECT_FALSE(same_bits(by_tree, by_simbody)) << "rounding tells them apart";
}

}  // namespace
}  // namespace skybody::test
