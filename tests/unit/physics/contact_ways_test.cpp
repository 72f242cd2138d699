// Contact on tree and on Simbody: equal forces and equal results.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/tree_dynamics.h"

namespace skybody::test {
namespace {

Shape random_shape(Random<double>& random) {
  const auto size = [&] { return random.uniform(0.05, 0.4); };
  const double kind = random.uniform();
  Shape shape = kind < 0.25   ? make_sphere(size())
                : kind < 0.5  ? make_cylinder(size(), size())
                : kind < 0.75 ? make_capsule(size(), size())
                              : make_box(size(), size(), size());
  shape.pose = {in_cube(random, 0.1), random.quaternion()};
  return shape;
}

/// One of these, a plane or hills.
Shape random_obstacle(Random<double>& random) {
  const double kind = random.uniform();
  if (kind < 0.6) return random_shape(random);
  Shape shape = kind < 0.7 ? make_plane() : make_height_field(1.0, 1.4, 6, 9, [&](double, double) {
    return random.uniform(-0.1, 0.1);
  });
  shape.pose = {in_cube(random, 0.1), random.quaternion()};
  return shape;
}

/// Two robots, the second with or without an arm, and an obstacle, crowded together.
Scenario crowd(Random<double>& random, bool has_arm) {
  const Vec3<double> com = has_arm ? Vec3<double>{0.01, 0.02, -0.01} : Vec3<double>{0, 0, 0};
  RobotModel first = make_free_body(1.0, diagonal(0.01, 0.012, 0.015), com);
  first.bodies[0].collisions = {random_shape(random)};
  RobotModel second = make_free_body(0.7, diagonal(0.008, 0.01, 0.012));
  second.bodies[0].collisions = {random_shape(random)};
  if (has_arm) {
    second.bodies.push_back(
        make_body("arm", JointType::kPin, 0, 0.3, {0.1, 0, 0}, diagonal(2e-3, 3e-3, 3e-3)));
    second.bodies[1].collisions = {random_shape(random)};
  }
  Scenario scenario = make_scenario(first, IntegratorChoice::kMidpoint);
  RobotUse use;
  use.name = "s";
  use.model = second;
  scenario.robots.push_back(use);
  scenario.obstacles.push_back({"obstacle", random_obstacle(random)});
  return scenario;
}

void scatter(Random<double>& random, Bench& bench) {
  random_state(random, bench.world, bench.state.q, bench.state.u);
  store(in_cube(random, 0.3), bench.state.q.data());
  store(in_cube(random, 0.3), bench.state.q.data() + 7);
}

class ContactOnBothDynamics : public testing::TestWithParam<int> {};

/// 100,000 states in all the blocks.
TEST_P(ContactOnBothDynamics, GivesTheSameAccelerations) {
  int touching = 0;
  std::set<std::pair<ShapeType, ShapeType>> kinds;  // of the crowded shapes
  for (std::uint64_t k = 0; k < 125; ++k) {
    Random<double> random{RandomKey{2026, 61}, k, static_cast<std::uint64_t>(GetParam()),
                          derive_stream("contact_ways_test")};
    Bench bench(crowd(random, k % 2 == 0));
    const auto simbody = make_simbody_stepper(bench.world);
    const auto kind_of = [&](int robot) {
      return bench.world.scenario.robots[static_cast<std::size_t>(robot)]
          .model.bodies[0]
          .collisions[0]
          .type;
    };
    kinds.insert({kind_of(0), kind_of(1)});
    std::vector<double> by_tree(bench.state.u.size()), by_simbody(bench.state.u.size());
    for (int i = 0; i < 200; ++i) {
      scatter(random, bench);
      std::vector<Contact> contacts;
      bench.stepper->add_contacts(bench.state, contacts);
      touching += !contacts.empty();
      bench.stepper->accelerations(bench.state, by_tree.data());
      simbody->accelerations(bench.state, by_simbody.data());
      double largest = 0.0;
      for (const double a : by_tree) largest = std::fmax(largest, std::fabs(a));
      // Masses of 0.3 to 1 kg: some thousand roundings of the largest.
      for (std::size_t n = 0; n < by_tree.size(); ++n) {
        ASSERT_NEAR(by_tree[n], by_simbody[n], 1e-11 * (1.0 + largest)) << k << ' ' << i;
      }
    }
  }
  EXPECT_GT(touching, 12'500);
  EXPECT_EQ(kinds.size(), 16u) << "all pairs of boxes, cylinders and spheres";
}

INSTANTIATE_TEST_SUITE_P(Blocks, ContactOnBothDynamics, testing::Range(0, 4));

/// The bodies' origins are their centres of mass. Otherwise a step moves the velocity of the
/// origin, and the momentum is right only to second order in dt, as in free flight.
TEST(Robots, KeepTheirMomentumInACollision) {
  for (std::uint64_t k = 0; k < 40; ++k) {
    Random<double> random{RandomKey{2026, 62}, k, 0, derive_stream("contact_ways_test")};
    Scenario scenario = crowd(random, false);
    scenario.obstacles.clear();
    scenario.contact.ground = false;
    scenario.constants[kGravity + 2] = 0.0;
    Bench bench(std::move(scenario));
    random_state(random, bench.world, bench.state.q, bench.state.u);
    for (double& u : bench.state.u) u = 0.0;
    store(Vec3<double>{-0.8, 0.0, 0.0}, bench.state.q.data());
    store(Vec3<double>{0.8, 0.05, 0.02}, bench.state.q.data() + 7);
    bench.state.u[0] = 2.0;
    bench.stepper->update_bodies(bench.state);
    const auto momentum = [&] {
      Vec3<double> sum{0, 0, 0};
      for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
        const MassProperties& m = bench.world.bodies[i].model->mass;
        const BodyState& b = bench.state.bodies[i];
        sum += m.mass * (b.velocity + rotate(b.rotation, cross(b.angular_velocity, m.com)));
      }
      return sum;
    };
    const Vec3<double> before = momentum();
    ASSERT_TRUE(bench.run(800));
    EXPECT_LT(norm(momentum() - before), 1e-12) << k;
  }
}

}  // namespace
}  // namespace skybody::test
