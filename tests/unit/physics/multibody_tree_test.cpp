// The articulated-body algorithm against Simbody, over random trees and near singularities.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/tree_dynamics.h"

namespace skybody::test {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The inputs of accelerations.
struct Point {
  explicit Point(const World& world)
      : q(world.layout.q.size),
        u(world.layout.u.size),
        joint_forces(u.size()),
        forces(world.bodies.size()) {}

  void draw(Random<double>& random, const World& world) {
    random_state(random, world, q, u);
    for (double& f : joint_forces) f = random.uniform(-1.0, 1.0);
    for (SpatialForce<double>& f : forces) f = {in_cube(random, 1.0), in_cube(random, 5.0)};
  }

  /// The same, with every number changed by some ulp.
  Point shaken(Random<double>& random) const {
    Point other = *this;
    const auto shake = [&](double& x) { x *= 1.0 + 4.0 * kEpsilon * random.uniform(-1.0, 1.0); };
    for (auto* values : {&other.q, &other.u, &other.joint_forces}) {
      for (double& x : *values) shake(x);
    }
    for (SpatialForce<double>& f : other.forces) {
      for (Vec3<double>* v : {&f.moment, &f.force}) shake(v->x), shake(v->y), shake(v->z);
    }
    return other;
  }

  std::vector<double> q, u, joint_forces;
  std::vector<SpatialForce<double>> forces;
};

std::vector<double> accelerations(Dynamics& dynamics, const Point& p) {
  std::vector<double> udot(p.u.size());
  dynamics.accelerations(p.q.data(), p.u.data(), p.forces.data(), p.joint_forces.data(),
                         udot.data());
  return udot;
}

/// Both dynamics of one world.
struct Pair {
  explicit Pair(Scenario scenario)
      : world(std::move(scenario)),
        tree(make_tree_dynamics(world)),
        simbody(make_nominal_simbody(world)) {
    const std::vector<double> params = nominal_params(world);
    tree->set_params(params.data());
    simbody->set_params(params.data());
  }

  /// Difference of the accelerations, and the part of it that rounding explains. First term: the
  /// change of Simbody's solution when its inputs change by a few ulp, times the number of
  /// roundings in either algorithm, some hundreds. Second term: errors independent of the inputs
  /// (rounding of constants, cancellation between large forces).
  void compare(Random<double>& random, const Point& p, double& difference, double& allowed) const {
    const std::vector<double> ours = accelerations(*tree, p), theirs = accelerations(*simbody, p);
    double moved = 0.0;
    for (int k = 0; k < 3; ++k) {
      moved =
          std::max(moved, largest_difference(accelerations(*simbody, p.shaken(random)), theirs));
    }
    difference = largest_difference(ours, theirs);
    allowed = 300.0 * moved + 1e-12 * (1.0 + largest(theirs));
  }

  const World world;
  std::unique_ptr<Dynamics> tree, simbody;
};

Random<double> random_numbers(std::uint64_t episode) {
  return {RandomKey{2026, 9}, episode, 0, derive_stream("tree_test")};
}

TEST(Tree, HasTheAccelerationsThatSimbodyFinds) {
  constexpr int kTrees = 2000, kStates = 50;  // 10^5 pairs
  for (std::uint64_t k = 0; k < kTrees; ++k) {
    Random<double> random = random_numbers(k);
    const Pair pair(make_scenario(random_tree(random)));
    if (pair.world.layout.u.size == 0) continue;
    Point point(pair.world);
    for (int i = 0; i < kStates; ++i) {
      point.draw(random, pair.world);
      double difference = 0.0, allowed = 0.0;
      pair.compare(random, point, difference, allowed);
      ASSERT_LE(difference, allowed) << "tree " << k << ", state " << i;
    }
  }
}

/// One step from the same state; coordinates may differ by dt times the difference of rates.
TEST(Tree, StepsAsSimbodyDoes) {
  for (std::uint64_t k = 0; k < 1000; ++k) {
    Random<double> random = random_numbers(100'000 + k);
    const RobotModel model = random_tree(random);
    const double dt = 1e-4 * std::pow(40.0, random.uniform());
    for (const auto integrator : kFixedSteps) {
      const Pair pair(make_scenario(model, integrator, dt));
      if (pair.world.layout.u.size == 0) break;
      const World world(make_scenario(model, integrator, dt));
      LaneState by_tree;
      write_default_state(world, by_tree);
      Point point(world);
      point.draw(random, world);
      by_tree.q = point.q;
      by_tree.u = point.u;
      LaneState by_simbody = by_tree;
      for (SpatialForce<double>& f : point.forces) f = {{0, 0, 0}, {0, 0, 0}};
      std::fill(point.joint_forces.begin(), point.joint_forces.end(), 0.0);
      double difference = 0.0, allowed = 0.0;
      pair.compare(random, point, difference, allowed);
      ASSERT_TRUE(make_tree_stepper(world)->advance(by_tree));
      ASSERT_TRUE(make_simbody_stepper(world)->advance(by_simbody));
      // RK4 also evaluates points within a step: ten times the bound at the start.
      const double rate = 10.0 * allowed * dt;
      EXPECT_LE(largest_difference(by_tree.u, by_simbody.u), rate + 1e-13) << "tree " << k;
      EXPECT_LE(largest_difference(by_tree.q, by_simbody.q), rate * dt + 1e-13) << "tree " << k;
    }
  }
}

/// @param moments  of the lightest body: the largest moment about its joint over the smallest;
///        rotating its inertia into other axes rounds by a few ulp of the largest, some hundred
///        times in all
void expect_agreement(const RobotModel& model, std::uint64_t seed, double moments = 1.0,
                      const std::function<void(const World&, Point&)>& place = {}) {
  const Pair pair(make_scenario(model));
  Random<double> random = random_numbers(seed);
  Point point(pair.world);
  for (int i = 0; i < 1000; ++i) {
    point.draw(random, pair.world);
    if (place) place(pair.world, point);
    double difference = 0.0, allowed = 0.0;
    pair.compare(random, point, difference, allowed);
    allowed += 100.0 * kEpsilon * moments * largest(accelerations(*pair.simbody, point));
    ASSERT_LE(difference, allowed) << "state " << i;
    ASSERT_LT(largest(accelerations(*pair.tree, point)), std::numeric_limits<double>::max());
  }
}

RobotModel base_with(Body body) {
  RobotModel model = make_free_body(1.5, diagonal(0.015, 0.017, 0.03));
  body.joint.frame_in_parent = {{0, 0, -0.05}, {1, 0, 0, 0}};
  body.joint.frame_in_body = {{0, 0, 0.3}, {1, 0, 0, 0}};
  model.bodies.push_back(std::move(body));
  return model;
}

TEST(TreeNearSingular, ALinkOfAMicrogramOnABallJoint) {
  expect_agreement(base_with(make_body("dust", JointType::kBall, 0, 1e-9, {0, 0, 0},
                                       diagonal(1e-15, 1e-15, 1e-15))),
                   1, 1e-9 * 0.3 * 0.3 / 1e-15);
}

TEST(TreeNearSingular, AThinRodThatTurnsAboutItsAxis) {
  expect_agreement(base_with(make_body("rod", JointType::kBall, 0, 0.02, {0, 0, 0},
                                       diagonal(1.5e-4, 1.5e-4, 1e-9))),
                   2, (1.5e-4 + 0.02 * 0.3 * 0.3) / 1e-9);
}

TEST(TreeNearSingular, AUniversalJointWhoseAxesAreAlmostOne) {
  const Body bob =
      make_body("bob", JointType::kUniversal, 0, 0.2, {0, 0, 0}, diagonal(1e-3, 1e-3, 1e-3));
  for (const double off : {1e-2, 1e-4, 1e-6}) {
    expect_agreement(base_with(bob), 3, 1.0, [off](const World& world, Point& p) {
      p.q[static_cast<std::size_t>(world.bodies[1].q) + 1] = 0.5 * kPi - off;
    });
  }
}

TEST(TreeNearSingular, AHeavyLoadOnALightVehicle) {
  expect_agreement(
      base_with(make_body("anvil", JointType::kPin, 0, 1e6, {0, 0, -1.0}, diagonal(1e5, 1e5, 1e5))),
      4);
}

/// A vehicle with a bob on a rod on a ball joint, standing on the bob.
Scenario vehicle_with_bob(DynamicsChoice dynamics) {
  RobotModel model = make_vehicle(qdrone2());
  Body rod = make_body("rod", JointType::kBall, 0, 0.1, {0, 0, 0}, diagonal(1e-3, 1e-3, 4e-5));
  rod.joint.frame_in_parent = {{0, 0, -0.06}, {1, 0, 0, 0}};
  rod.joint.frame_in_body = {{0, 0, 0.3}, {1, 0, 0, 0}};
  rod.joint.constants[kJointDamping] = 0.002;
  rod.collisions.push_back(make_sphere(0.03));
  model.bodies.push_back(std::move(rod));
  Scenario scenario = make_scenario(std::move(model));
  scenario.stepping.dynamics = dynamics;
  return scenario;
}

TEST(Tree, TakesOffLandsAndBouncesLikeSimbodys) {
  Bench tree(vehicle_with_bob(DynamicsChoice::kTree));
  Bench simbody(vehicle_with_bob(DynamicsChoice::kSimbody));
  double highest = 0.0, fastest_landing = 0.0, fastest_bounce = 0.0, most = 0.0;
  for (Bench* bench : {&tree, &simbody}) {
    bench->state.q[2] = 0.39;
    bench->state.rotor_speed.assign(4, 1400.0);
  }
  for (int i = 0; i < 1600; ++i) {
    for (Bench* bench : {&tree, &simbody}) {
      // Slightly tilted, so that the bob swings and the motion has no symmetry.
      const double speed = i < 600 ? 1600.0 : 1000.0;
      bench->state.rotor_command = {speed + 1.0, speed, speed, speed};
      ASSERT_TRUE(bench->run(1));
    }
    const BodyState& bob = tree.state.bodies[1];
    highest = std::fmax(highest, bob.position.z);
    fastest_landing = std::fmin(fastest_landing, bob.velocity.z);
    if (fastest_landing < -1.0) fastest_bounce = std::fmax(fastest_bounce, bob.velocity.z);
    most = std::fmax(most, largest_difference(tree.state.q, simbody.state.q));
    most = std::fmax(most, largest_difference(tree.state.u, simbody.state.u));
  }
  EXPECT_GT(highest, 0.3) << "took off";
  EXPECT_LT(fastest_landing, -1.0) << "came down";
  EXPECT_GT(fastest_bounce, 0.05) << "bounced";
  // 1600 roundings of 1e-16 each; the ground, with a natural frequency of some 100 rad/s, turns
  // differences of position into a hundred times larger ones of velocity.
  EXPECT_LT(most, 2e-11);
}

}  // namespace
}  // namespace skybody::test
