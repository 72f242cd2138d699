// Contact where it is hard: thin walls at high speed, edges, stacks, slopes, long rest.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/unit/physics/contact_worlds.h"
#include "tests/unit/physics/random_trees.h"

namespace skybody::test {
namespace {

TEST(Wall, NoBallPasses) {
  Random<double> random{RandomKey{2026, 51}, 0, 0, derive_stream("contact_robust_test")};
  int tries = 0;
  for (int k = 0; k < 600; ++k) {
    const double radius = random.uniform(0.01, 0.1), thickness = random.uniform(0.01, 0.1);
    const double speed = random.uniform(0.5, 20.0);
    const double dt = 1e-3 * std::pow(20.0, random.uniform()) * 0.1;
    Scenario scenario = world_of(solid(4000.0 * radius * radius * radius, make_sphere(radius)), dt);
    switch_off_gravity_and_ground(scenario);
    Obstacle wall;
    wall.name = "wall";
    wall.shape = make_box(thickness, 4.0, 4.0);
    wall.shape.pose.rotation = from_rpy(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), 0.0);
    scenario.obstacles.push_back(wall);
    Bench bench(scenario);
    const Quat<double> r = wall.shape.pose.rotation;
    const Vec3<double> out = rotate(r, {1, 0, 0}), along = rotate(r, {0, 1, 0});
    store(out * (radius + 0.5 * thickness + random.uniform(0.001, 0.1)), bench.state.q.data());
    store((out * -1.0 + along * random.uniform(-0.7, 0.7)) * speed, bench.state.u.data());
    const double before = energy(bench);
    bench.stepper->update_bodies(bench.state);
    for (int i = 0; i * dt < 0.3; ++i) {
      ASSERT_TRUE(bench.run(1));
      const double x = dot(out, load_vec3(bench.state.q.data()));
      ASSERT_GT(x, radius) << "try " << k << " step " << i << ": radius " << radius << ", wall "
                           << thickness << ", " << speed << " m/s, dt " << dt;
    }
    EXPECT_LE(energy(bench),
              1e-9 + before + 0.5 * speed * speed * 4000.0 * radius * radius * radius);
    ++tries;
  }
  EXPECT_EQ(tries, 600);
}

TEST(Wall, NoTumblingVehiclePasses) {
  Random<double> random{RandomKey{2026, 52}, 0, 0, derive_stream("contact_robust_test")};
  for (int k = 0; k < 400; ++k) {
    const double thickness = random.uniform(0.01, 0.1), speed = random.uniform(0.5, 20.0);
    const double dt = 1e-3 * std::pow(20.0, random.uniform()) * 0.1;
    Scenario scenario = world_of(make_vehicle(qdrone2()), dt);
    switch_off_gravity_and_ground(scenario);
    Obstacle wall;
    wall.name = "wall";
    wall.shape = make_box(thickness, 8.0, 8.0);
    scenario.obstacles.push_back(wall);
    Bench bench(scenario);
    bench.state.q[0] = 0.5;
    store(random.quaternion(), bench.state.q.data() + 3);
    bench.state.u[0] = -speed;
    for (int axis = 0; axis < 3; ++axis) bench.state.u[3 + axis] = random.uniform(-10.0, 10.0);
    bench.stepper->update_bodies(bench.state);
    const double before = energy(bench);
    for (int i = 0; i * dt < 0.4; ++i) {
      ASSERT_TRUE(bench.run(1));
      ASSERT_GT(bench.state.q[0], 0.0) << "try " << k << " step " << i << ": wall " << thickness
                                       << ", " << speed << " m/s, dt " << dt;
      ASSERT_LT(energy(bench), before * (1.0 + 1e-3)) << "try " << k << " step " << i;
    }
  }
}

/// Where a ball that flies at 2 m/s along x is after half a second.
double flown_to(const std::string& path, double value) {
  Scenario scenario = world_of(solid(0.1, make_sphere(0.02)));
  switch_off_gravity_and_ground(scenario);
  scenario.obstacles.push_back({"wall", make_box(0.1, 1.0, 1.0)});
  scenario.obstacles[0].shape.pose.position = {0.5, 0.0, 0.0};
  Bench bench(std::move(scenario));
  bench.state.u[0] = 2.0;
  if (!path.empty()) bench.param(path) = value;
  EXPECT_TRUE(bench.run_seconds(0.5));
  return bench.state.q[0];
}

TEST(Obstacle, IsWhereItsParametersSay) {
  EXPECT_LT(flown_to("", 0.0), 0.44) << "stopped";
  EXPECT_NEAR(flown_to("obstacles.wall.present", 0.0), 1.0, 1e-9);
  EXPECT_NEAR(flown_to("obstacles.wall.position[1]", 2.0), 1.0, 1e-9);
  EXPECT_NEAR(flown_to("obstacles.wall.position[0]", 2.0), 1.0, 1e-9);
  EXPECT_LT(flown_to("obstacles.wall.position[0]", 0.8), 0.74);
  EXPECT_GT(flown_to("obstacles.wall.position[0]", 0.8), 0.6);
  EXPECT_NEAR(flown_to("obstacles.wall.size[1]", 0.5), flown_to("", 0.0), 1e-9);
  EXPECT_LT(flown_to("obstacles.wall.size[0]", 0.6), 0.19);
  // A quarter of a turn about z, and the wall's narrow side looks at the ball: its corner is 0.5 m
  // from its centre.
  EXPECT_LT(flown_to("obstacles.wall.rotation[3]", 1.0), 0.1);
}

TEST(Obstacle, OfNoSizeIsAFaultOfItsEnvironment) {
  Scenario scenario = world_of(solid(0.1, make_sphere(0.02)));
  scenario.obstacles.push_back({"wall", make_box(0.1, 1.0, 1.0)});
  Bench bench(std::move(scenario));
  bench.param("obstacles.wall.size[1]") = 0.0;
  EXPECT_FALSE(bench.run(1));
  std::vector<double> udot(6);
  EXPECT_THROW(bench.stepper->accelerations(bench.state, udot.data()), Error);
  bench.param("obstacles.wall.present") = 0.0;
  EXPECT_TRUE(bench.run(1));
}

TEST(Stack, OfThreeBoxesRestsForAMinute) {
  Scenario scenario = world_of(solid(1.0, make_box(0.2, 0.2, 0.1)));
  scenario.robots[0].pose.position = {0, 0, 0.05};
  add_robot(scenario, "s", solid(1.0, make_box(0.2, 0.2, 0.1)), {{0.02, 0.01, 0.15}, {1, 0, 0, 0}});
  add_robot(scenario, "t", solid(1.0, make_box(0.2, 0.2, 0.1)),
            {{-0.02, 0.03, 0.25}, from_rpy(0.0, 0.0, 0.3)});
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(3.0));
  const std::vector<double> rest = bench.state.q;
  for (int i = 0; i < 57; ++i) {
    ASSERT_TRUE(bench.run_seconds(1.0));
    for (int b = 0; b < 3; ++b) {
      for (int k = 0; k < 3; ++k) {
        ASSERT_NEAR(bench.state.q[7 * b + k], rest[7 * b + k], 1e-3) << i << " s, box " << b;
      }
    }
  }
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  double carried = 0.0;
  for (const Contact& c : contacts) carried += c.other == kGround ? c.force.z : 0.0;
  EXPECT_NEAR(carried, 3.0 * 9.81, 1e-3);
}

/// A box on a slope below the angle of friction, by tilted gravity.
TEST(Slope, BelowTheAngleOfFrictionABoxStays) {
  Scenario scenario = world_of(solid(1.0, make_box(0.2, 0.2, 0.1)));
  const double angle = 0.5;  // tan 0.546, friction 0.6
  scenario.constants[kGravity] = 9.81 * std::sin(angle);
  scenario.constants[kGravity + 2] = -9.81 * std::cos(angle);
  scenario.robots[0].pose.position = {0, 0, 0.05};
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(3.0));
  const double rest = bench.state.q[0];
  ASSERT_TRUE(bench.run_seconds(57.0));
  EXPECT_NEAR(bench.state.q[0], rest, 1e-5);
  EXPECT_LT(std::fabs(bench.state.u[0]), 1e-6);
}

TEST(Slope, AboveItItSlides) {
  Scenario scenario = world_of(solid(1.0, make_box(0.2, 0.2, 0.1)));
  const double angle = 0.6;  // tan 0.684
  scenario.constants[kGravity] = 9.81 * std::sin(angle);
  scenario.constants[kGravity + 2] = -9.81 * std::cos(angle);
  scenario.robots[0].pose.position = {0, 0, 0.049};
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(0.5));
  const double before = bench.state.u[0];
  ASSERT_TRUE(bench.run_seconds(0.5));
  const double wanted = 9.81 * (std::sin(angle) - 0.6 * std::cos(angle));
  EXPECT_NEAR(bench.state.u[0] - before, 0.5 * wanted, 0.01 * wanted);
}

TEST(Edges, CrossedRodsMeetBetweenTheirEnds) {
  for (const bool is_box : {true, false}) {
    const Shape rod = is_box ? make_box(0.02, 0.02, 1.0) : make_cylinder(0.01, 1.0);
    RobotModel upper = solid(0.2, rod), lower = solid(0.2, rod);
    Scenario scenario = world_of(upper);
    switch_off_gravity_and_ground(scenario);
    // The first lies along x, turned about its axis so that its edge looks at the other.
    scenario.robots[0].pose = {{0, 0, 0.05}, from_rpy(0.0, 0.5 * kPi, 0.25 * kPi)};
    add_robot(scenario, "s", lower, {{0, 0.1, 0}, from_rpy(0.5 * kPi, 0.0, 0.1)});
    Bench bench(scenario);
    bench.state.u[2] = -1.0;
    ASSERT_TRUE(bench.run_seconds(0.2));
    EXPECT_GT(bench.state.u[8], 0.0 - 1.0);
    EXPECT_LT(bench.state.u[8], -0.05) << "the lower was pushed down, box " << is_box;
    EXPECT_NEAR(bench.state.u[2] + bench.state.u[8], -1.0, 1e-12);
  }
}

/// Two QDrone2 meet: how far a result is from that of the finest step. At 1 m/s they graze each
/// other once more 0.21 s later, which amplifies any difference 200 times: it is looked at before.
TEST(Collision, ConvergesAsTheStepFalls) {
  const auto fly = [](double dt, double speed) {
    Scenario scenario = world_of(make_vehicle(qdrone2()), dt);
    switch_off_gravity_and_ground(scenario);
    scenario.robots[0].pose = {{-0.5, 0.02, 3.0}, from_rpy(0.05, 0.1, 0.3)};
    add_robot(scenario, "s", make_vehicle(qdrone2()),
              {{0.5, -0.03, 3.01}, from_rpy(-0.1, 0.05, -0.4)});
    Bench bench(scenario);
    bench.state.u[0] = 0.5 * speed;
    bench.state.u[6] = -0.5 * speed;
    EXPECT_TRUE(bench.run_seconds(0.65 / speed + (speed > 1.0 ? 0.6 : 0.2)));
    return bench.state.q;
  };
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double most = 0.0;
    for (const std::size_t k : {0, 1, 2, 7, 8, 9}) most = std::fmax(most, std::fabs(a[k] - b[k]));
    return most;
  };
  const std::vector<double> quick = fly(2.5e-5, 5.0), slow = fly(2.5e-5, 1.0);
  for (const double dt : {2e-3, 1e-3, 5e-4, 1e-4}) {
    EXPECT_LT(apart(fly(dt, 5.0), quick), 0.01) << dt;
    EXPECT_LT(apart(fly(dt, 1.0), slow), 1e-3) << dt;
  }
  EXPECT_LT(apart(fly(5e-5, 5.0), quick), apart(fly(2e-3, 5.0), quick));
}

TEST(Bounces, NeverGainEnergy) {
  Random<double> random{RandomKey{2026, 53}, 0, 0, derive_stream("contact_robust_test")};
  int bounces = 0;
  for (int k = 0; bounces < 10'000; ++k) {
    const auto size = [&] { return random.uniform(0.03, 0.3); };
    const double kind = random.uniform();
    const Shape shape = kind < 0.3   ? make_sphere(size())
                        : kind < 0.6 ? make_cylinder(size(), size())
                                     : make_box(size(), size(), size());
    Scenario scenario =
        world_of(solid(random.uniform(0.05, 5.0), shape), random.uniform() < 0.5 ? 1e-3 : 2e-3);
    scenario.constants[kGravity + 2] = 0.0;
    scenario.constants[kDissipation] = random.uniform(0.1, 3.0);
    Obstacle table;
    table.name = "table";
    table.shape = make_box(size() * 3, size() * 3, size());
    table.shape.pose = {{0, 0, 3.0}, random.quaternion()};
    scenario.obstacles.push_back(table);
    Bench bench(scenario);
    const Vec3<double> from = in_cube(random, 1.0);
    const Vec3<double> at = from * (1.3 / norm(from));
    store(at + Vec3<double>{0, 0, 3.0}, bench.state.q.data());
    store(random.quaternion(), bench.state.q.data() + 3);
    store(at * (-random.uniform(0.5, 12.0) / 1.3), bench.state.u.data());
    for (int axis = 0; axis < 3; ++axis) bench.state.u[3 + axis] = random.uniform(-8.0, 8.0);
    bench.stepper->update_bodies(bench.state);
    const double before = energy(bench);
    bool touched = false;
    for (int i = 0; i < 600; ++i) {
      ASSERT_TRUE(bench.run(1));
      touched |= bench.stepper->was_near();
      // Free spin by the midpoint rule keeps it to 1e-5 of itself.
      ASSERT_LT(energy(bench), before * (1.0 + 1e-4)) << "flight " << k << " step " << i;
    }
    bounces += touched;
  }
}

}  // namespace
}  // namespace skybody::test
