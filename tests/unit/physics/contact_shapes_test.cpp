// Bodies on planes, hills and capsules, and capsules and cylinders that roll, rest and hit walls.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/math/random.h"
#include "tests/unit/physics/contact_worlds.h"
#include "tests/unit/physics/random_trees.h"

namespace skybody::test {
namespace {

constexpr double kSunk = 0.001;  ///< ContactSettings::penetration

/// A world without the ground, with an obstacle in its place.
Scenario world_on(const Shape& ground, RobotModel model, const Pose& start, double dt = 1e-3) {
  Scenario scenario = world_of(std::move(model), dt);
  scenario.contact.ground = false;
  scenario.obstacles.push_back({"floor", ground});
  scenario.robots[0].pose = start;
  return scenario;
}

Shape flat_field() {
  return make_height_field(4.0, 4.0, 41, 41, [](double, double) { return 0.0; });
}

double carried(Bench& bench) {
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  double sum = 0.0;
  for (const Contact& c : contacts) sum += c.force.z;
  return sum;
}

TEST(Plane, IsTheGroundSomewhereElse) {
  for (const Shape& shape : {make_sphere(0.05), make_box(0.2, 0.1, 0.06), make_cylinder(0.05, 0.1),
                             make_capsule(0.04, 0.1)}) {
    const Pose start{{0.0, 0.0, 0.3}, from_rpy(0.4, 0.3, 0.2)};
    Bench on_plane(world_on(make_plane(), solid(0.5, shape), start));
    Scenario scenario = world_of(solid(0.5, shape));
    scenario.robots[0].pose = start;
    Bench on_ground(std::move(scenario));
    on_plane.state.u[0] = on_ground.state.u[0] = 1.0;
    ASSERT_TRUE(on_plane.run_seconds(0.5));
    ASSERT_TRUE(on_ground.run_seconds(0.5));
    // The same law at the same contacts; sums of roundings through some impacts.
    for (std::size_t k = 0; k < on_plane.state.q.size(); ++k) {
      EXPECT_NEAR(on_plane.state.q[k], on_ground.state.q[k], 1e-6) << static_cast<int>(shape.type);
    }
  }
}

TEST(Plane, BallRollsDownAsARigidBallDoes) {
  for (const bool is_field : {false, true}) {
    Shape slope = is_field ? flat_field() : make_plane();
    const double angle = 0.3;  // tan 0.31, below 7/2 of the friction of 0.6
    slope.pose.rotation = from_rpy(0.0, angle, 0.0);
    const double radius = 0.05;
    const Vec3<double> up = rotate(slope.pose.rotation, {0, 0, 1});
    Bench bench(world_on(slope, solid(0.5, make_sphere(radius)), {up * radius, {1, 0, 0, 0}}));
    ASSERT_TRUE(bench.run_seconds(0.2));
    const double before = norm(load_vec3(bench.state.u.data()));
    ASSERT_TRUE(bench.run_seconds(0.5));
    const double after = norm(load_vec3(bench.state.u.data()));
    EXPECT_NEAR(after - before, 0.5 * 5.0 / 7.0 * 9.81 * std::sin(angle), 0.01) << is_field;
    EXPECT_NEAR(std::fabs(bench.state.u[4]) * radius, after, 0.02 * after) << "it rolls";
  }
}

TEST(Plane, FarBelowItsSurfaceABodyIsPushedUp) {
  Bench bench(world_on(make_plane(), solid(1.0, make_sphere(0.1)), {{0, 0, -3.0}, {1, 0, 0, 0}}));
  ASSERT_TRUE(bench.run(1));
  EXPECT_GT(bench.state.u[2], 0.0);
}

TEST(Endless, ATumblingBoxComesToRestOnIt) {
  Random<double> random{RandomKey{2026, 81}, 0, 0, derive_stream("contact_shapes_test")};
  const Shape rough = make_height_field(6.0, 6.0, 61, 61, [&](double x, double y) {
    return 0.02 * x * x + 0.02 * y * y + random.uniform(0.0, 0.01);
  });
  const Shape capsule_floor = make_capsule(3.0, 10.0);
  for (int k = 0; k < 9; ++k) {
    Shape floor = k % 3 == 0 ? make_plane() : k % 3 == 1 ? rough : capsule_floor;
    if (k % 3 == 2) floor.pose = {{0, 0, -3.0}, from_rpy(0.5 * kPi, 0.0, 0.0)};
    Bench bench(
        world_on(floor, solid(1.0, make_box(0.3, 0.2, 0.1)), {{0, 0, 0.5}, random.quaternion()}));
    for (int axis = 0; axis < 3; ++axis) bench.state.u[3 + axis] = random.uniform(-8.0, 8.0);
    ASSERT_TRUE(bench.run_seconds(k % 3 == 2 ? 1.5 : 6.0));
    // On the round back of a capsule it may rock and finally slide off.
    if (k % 3 != 2) {
      EXPECT_LT(norm(load_vec3(bench.state.u.data())), 0.01) << k;
    }
    EXPECT_GT(bench.state.q[2], 0.03) << k;
    EXPECT_LT(bench.state.q[2], 0.4) << k;
    if (k % 3 == 0) {
      EXPECT_NEAR(carried(bench), 9.81, 0.01) << k;
    }
  }
}

/// Peaks of 0.2 m at given corners of a grid of 0.1 m.
Shape peaks(std::initializer_list<std::pair<int, int>> places) {
  return make_height_field(1.0, 1.0, 11, 11, [&](double x, double y) {
    for (const auto& [c, r] : places) {
      if (std::fabs(x - 0.1 * c) < 0.01 && std::fabs(y - 0.1 * r) < 0.01) return 0.2;
    }
    return 0.0;
  });
}

TEST(HeightField, PeaksCarryTheFlatFaceOfABox) {
  Bench bench(world_on(peaks({{-2, -2}, {2, -2}, {0, 3}}), solid(1.0, make_box(0.8, 0.8, 0.1)),
                       {{0, 0, 0.2501}, {1, 0, 0, 0}}));
  ASSERT_TRUE(bench.run_seconds(2.0));
  EXPECT_NEAR(bench.state.q[2], 0.25, 4.0 * kSunk);
  EXPECT_LT(norm(load_vec3(bench.state.u.data())), 1e-3);
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  EXPECT_EQ(contacts.size(), 3u);
  EXPECT_NEAR(carried(bench), 9.81, 1e-2);
}

TEST(HeightField, APlateauCarriesABoxAtItsCorners) {
  const Shape table = make_height_field(2.0, 2.0, 21, 21, [](double x, double y) {
    return std::fabs(x) < 0.25 && std::fabs(y) < 0.25 ? 0.3 : 0.0;
  });
  Bench bench(world_on(table, solid(1.0, make_box(1.0, 1.0, 0.1)), {{0, 0, 0.35}, {1, 0, 0, 0}}));
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_NEAR(bench.state.q[2], 0.35, 2.0 * kSunk);
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  EXPECT_GE(contacts.size(), 4u);
  EXPECT_LE(contacts.size(), 8u);
}

TEST(HeightField, RidgesCarryTheEdgesOfABoxAndRods) {
  const Shape ridges = make_height_field(2.0, 2.0, 21, 21, [](double x, double) {
    return std::fabs(std::fabs(x) - 0.3) < 0.01 ? 0.2 : 0.0;
  });
  const Quat<double> along_x = from_rpy(0.0, 0.5 * kPi, 0.0);
  struct Case {
    Shape shape;
    double height;  ///< of its middle above the ridges
    Quat<double> rotation;
  };
  for (const Case& c : {Case{make_box(1.0, 0.25, 0.1), 0.05, {1, 0, 0, 0}},
                        Case{make_capsule(0.05, 1.0), 0.05, along_x},
                        Case{make_cylinder(0.05, 1.1), 0.05, along_x}}) {
    Bench bench(world_on(ridges, solid(1.0, c.shape), {{0.02, 0.01, 0.2 + c.height}, c.rotation}));
    ASSERT_TRUE(bench.run_seconds(1.0));
    EXPECT_NEAR(bench.state.q[2], 0.2 + c.height, 4.0 * kSunk) << static_cast<int>(c.shape.type);
    EXPECT_NEAR(carried(bench), 9.81, 0.2) << static_cast<int>(c.shape.type);
  }
}

TEST(HeightField, ABoxOverTheEdgeOfATableTipsWhereItsMiddleIsBeyond) {
  const Shape table =
      make_height_field(2.0, 2.0, 21, 21, [](double x, double) { return x < 0.05 ? 0.5 : 0.0; });
  // The table's top ends at x = 0, its flank at 0.1.
  for (const bool tips : {false, true}) {
    Bench bench(world_on(table, solid(1.0, make_box(0.4, 0.2, 0.1)),
                         {{tips ? 0.03 : -0.03, 0, 0.55}, {1, 0, 0, 0}}));
    ASSERT_TRUE(bench.run_seconds(1.0));
    if (tips) {
      EXPECT_LT(bench.state.q[2], 0.5);
    } else {
      EXPECT_NEAR(bench.state.q[2], 0.55, 4.0 * kSunk);
    }
  }
}

TEST(HeightField, ABallRestsInAHollowAndOnFineGround) {
  const Shape hollow =
      make_height_field(2.0, 2.0, 81, 81, [](double x, double y) { return 0.3 * (x * x + y * y); });
  Bench bench(world_on(hollow, solid(0.5, make_sphere(0.1)), {{0.4, 0.1, 0.4}, {1, 0, 0, 0}}));
  ASSERT_TRUE(bench.run_seconds(5.0));
  EXPECT_LT(std::hypot(bench.state.q[0], bench.state.q[1]), 0.6);
  EXPECT_GT(bench.state.q[2], 0.095);
  EXPECT_NEAR(carried(bench), 0.5 * 9.81, 1.0);
}

TEST(HeightField, IsWhereAndAsLargeAsItsParametersSay) {
  const auto height_after = [](const std::string& path, double value) {
    Bench bench(
        world_on(flat_field(), solid(0.5, make_sphere(0.1)), {{1.0, 0, 0.1}, {1, 0, 0, 0}}));
    if (!path.empty()) bench.param(path) = value;
    EXPECT_TRUE(bench.run_seconds(0.5));
    return bench.state.q[2];
  };
  EXPECT_NEAR(height_after("", 0.0), 0.1, 2.0 * kSunk);
  EXPECT_LT(height_after("obstacles.floor.present", 0.0), -1.0);
  EXPECT_LT(height_after("obstacles.floor.size[0]", 1.5), -1.0) << "it ends before the ball";
  EXPECT_LT(height_after("obstacles.floor.position[0]", -2.0), -1.0);
  EXPECT_NEAR(height_after("obstacles.floor.size[1]", 1.0), 0.1, 2.0 * kSunk);
}

TEST(Capsule, LiesAndRollsOnTheGroundAtItsRadius) {
  Scenario scenario = world_of(solid(0.5, make_capsule(0.05, 0.3)));
  scenario.robots[0].pose = {{0, 0, 0.05}, from_rpy(0.5 * kPi, 0.0, 0.0)};
  Bench bench(scenario);
  bench.state.u[0] = 1.0;  // across its axis, which lies along y
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(bench.run_seconds(0.01));
    ASSERT_NEAR(bench.state.q[2], 0.05, 2.0 * kSunk);
  }
  EXPECT_GT(bench.state.u[0], 0.5) << "it rolls on";
}

TEST(Capsule, StandsBetweenTwoOthersThatLie) {
  for (const Shape& shape : {make_sphere(0.1), make_box(0.2, 0.2, 0.2), make_cylinder(0.1, 0.2),
                             make_capsule(0.1, 0.4)}) {
    Scenario scenario = world_of(solid(0.5, shape));
    scenario.contact.ground = false;
    const Quat<double> along_x = from_rpy(0.0, 0.5 * kPi, 0.0);
    scenario.robots[0].pose = {{0, 0, 0.25}, along_x};
    for (const double y : {-0.1, 0.1}) {
      Shape bar = make_capsule(0.08, 2.0);
      bar.pose = {{0, y, 0}, along_x};
      scenario.obstacles.push_back({y < 0 ? "left" : "right", bar});
    }
    Bench bench(scenario);
    ASSERT_TRUE(bench.run_seconds(2.0));
    EXPECT_NEAR(bench.state.q[1], 0.0, 0.02) << static_cast<int>(shape.type);
    EXPECT_GT(bench.state.q[2], 0.1) << static_cast<int>(shape.type);
    EXPECT_LT(norm(load_vec3(bench.state.u.data())), 1e-3) << static_cast<int>(shape.type);
  }
}

TEST(Capsule, CrossedOnesMeetBetweenTheirEnds) {
  Scenario scenario = world_of(solid(0.2, make_capsule(0.01, 1.0)));
  switch_off_gravity_and_ground(scenario);
  scenario.robots[0].pose = {{0, 0, 0.05}, from_rpy(0.0, 0.5 * kPi, 0.0)};
  add_robot(scenario, "s", solid(0.2, make_capsule(0.01, 1.0)),
            {{0, 0.1, 0}, from_rpy(0.5 * kPi, 0.0, 0.1)});
  Bench bench(scenario);
  bench.state.u[2] = -1.0;
  ASSERT_TRUE(bench.run_seconds(0.2));
  EXPECT_LT(bench.state.u[8], -0.05) << "the lower was pushed down";
  EXPECT_NEAR(bench.state.u[2] + bench.state.u[8], -1.0, 1e-12);
}

TEST(Capsule, NonePassesAWallNorAWallOfCapsules) {
  Random<double> random{RandomKey{2026, 82}, 0, 0, derive_stream("contact_shapes_test")};
  for (int k = 0; k < 300; ++k) {
    const double radius = random.uniform(0.01, 0.08), thickness = random.uniform(0.01, 0.1);
    const double speed = random.uniform(0.5, 20.0), dt = 1e-4 * std::pow(20.0, random.uniform());
    const bool is_box = k % 2 == 0;
    const Shape flies = k % 3 == 0 ? make_sphere(radius) : make_capsule(radius, 3.0 * radius);
    Scenario scenario = world_of(solid(8000.0 * radius * radius * radius, flies), dt);
    switch_off_gravity_and_ground(scenario);
    if (is_box) {
      scenario.obstacles.push_back({"wall", make_box(thickness, 8.0, 8.0)});
    } else {  // bars side by side
      for (int i = -20; i <= 20; ++i) {
        scenario.obstacles.push_back(
            {"bar_" + std::to_string(i + 20), make_capsule(0.5 * thickness, 8.0)});
        scenario.obstacles.back().shape.pose.position.y = 0.5 * thickness * i;
      }
    }
    Bench bench(scenario);
    bench.state.q[0] = 3.0 * radius + thickness;
    store(random.quaternion(), bench.state.q.data() + 3);
    bench.state.u[0] = -speed;
    for (int axis = 0; axis < 3; ++axis) bench.state.u[3 + axis] = random.uniform(-10.0, 10.0);
    bench.stepper->update_bodies(bench.state);
    for (int i = 0; i * dt < 0.2; ++i) {
      ASSERT_TRUE(bench.run(1));
      if (std::fabs(bench.state.q[1]) > 7.0 * thickness) break;  // beside the bars
      ASSERT_GT(bench.state.q[0], 0.0)
          << "try " << k << " step " << i << ": radius " << radius << ", wall " << thickness << ", "
          << speed << " m/s, dt " << dt << (is_box ? ", box" : ", bars");
    }
  }
}

TEST(Rim, RollsAtOneHeight) {
  for (const bool on_box : {false, true}) {
    const double radius = 0.1;
    Scenario scenario = world_of(solid(0.5, make_cylinder(radius, 0.1)));
    if (on_box) {
      scenario.contact.ground = false;
      scenario.obstacles.push_back({"table", make_box(4.0, 4.0, 1.0)});
      scenario.obstacles[0].shape.pose.position.z = -0.5;
    }
    // Upright it would stand on nine points of a rim; lying, it rests on one point of each rim.
    const double sunk = kSunk * std::pow(9.0 / 2.0, 2.0 / 3.0);
    scenario.robots[0].pose = {{0, 0, radius - sunk}, from_rpy(0.5 * kPi, 0.0, 0.0)};
    Bench bench(scenario);
    bench.state.u[0] = 0.5;
    bench.state.u[5] = -0.5 / radius;  // about its axis, which lies along y of W
    double low = kInfinity, high = -kInfinity;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(bench.run(1));
      low = std::fmin(low, bench.state.q[2]);
      high = std::fmax(high, bench.state.q[2]);
    }
    // With its eight rim points only, it would sink in by 8 mm. On a box fixed points also carry as
    // they pass.
    EXPECT_GT(low, radius - sunk - (on_box ? 0.5 : 0.1) * kSunk) << on_box;
    EXPECT_LT(high - low, on_box ? 2.0 * kSunk : 0.01 * kSunk) << on_box;
    EXPECT_NEAR(bench.state.u[0], 0.5, on_box ? 0.05 : 0.001) << on_box;
  }
}

TEST(Rim, LowestPointIsThatOfTheCircle) {
  Random<double> random{RandomKey{2026, 83}, 0, 0, derive_stream("contact_shapes_test")};
  const double radius = 0.1, half = 0.05;
  for (const bool is_plane : {false, true}) {
    for (int k = 0; k < 200; ++k) {
      const Quat<double> rotation = random.quaternion();
      const Vec3<double> axis = rotate(rotation, {0, 0, 1});
      const double tilt = std::sqrt(1.0 - axis.z * axis.z);
      const double lowest = -half * std::fabs(axis.z) - radius * tilt;
      Scenario scenario = world_on(make_plane(), solid(0.5, make_cylinder(radius, 2.0 * half)), {});
      if (!is_plane) scenario.obstacles.clear();
      scenario.contact.ground = !is_plane;
      Bench bench(scenario);
      bench.state.q[2] = -lowest - 0.002;
      store(rotation, bench.state.q.data() + 3);
      bench.stepper->update_bodies(bench.state);
      std::vector<Contact> contacts;
      bench.stepper->add_contacts(bench.state, contacts);
      double deepest = 0.0;
      for (const Contact& c : contacts) deepest = std::fmax(deepest, c.depth);
      if (tilt > 0.01) {
        EXPECT_NEAR(deepest, 0.002, 1e-9) << k;
      } else {
        EXPECT_NEAR(deepest, 0.002, 0.01 * radius * 0.08) << k;
      }
    }
  }
}

TEST(Rim, OfAnUprightCylinderRestsOnSeveralPointsAndDoesNotCreep) {
  Scenario scenario = world_of(solid(0.5, make_cylinder(0.05, 0.1)));
  const double angle = 0.3;
  scenario.constants[kGravity] = 9.81 * std::sin(angle);
  scenario.constants[kGravity + 2] = -9.81 * std::cos(angle);
  scenario.robots[0].pose.position.z = 0.05;
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(3.0));
  const std::vector<double> rest = bench.state.q;
  ASSERT_TRUE(bench.run_seconds(30.0));
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(bench.state.q[i], rest[i], 1e-5) << i;
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  EXPECT_GE(contacts.size(), 5u);
  EXPECT_NEAR(carried(bench), 0.5 * 9.81 * std::cos(angle), 1e-3);
}

TEST(Mesh, CountsAsTheBoxAboutIt) {
  Shape mesh;
  mesh.type = ShapeType::kMesh;
  mesh.pose = {{0.1, 0.0, 0.0}, from_rpy(0.0, 0.0, 0.5 * kPi)};
  mesh.box_size = {0.2, 0.1, 0.06};
  mesh.box_center = {0.0, 0.1, 0.0};
  Shape box = make_box(0.2, 0.1, 0.06);
  box.pose = {{0.0, 0.0, 0.0}, mesh.pose.rotation};
  std::vector<double> q[2];
  for (int k = 0; k < 2; ++k) {
    RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
    model.bodies[0].collisions = {k == 0 ? mesh : box};
    Scenario scenario = world_of(model);
    scenario.robots[0].pose = {{0, 0, 0.2}, from_rpy(0.2, 0.1, 0.0)};
    Bench bench(scenario);
    ASSERT_TRUE(bench.run_seconds(0.4));
    q[k] = bench.state.q;
  }
  for (std::size_t k = 0; k < q[0].size(); ++k) EXPECT_NEAR(q[0][k], q[1][k], 1e-9);
}

TEST(Bounces, OfNewShapesNeverGainEnergy) {
  Random<double> random{RandomKey{2026, 84}, 0, 0, derive_stream("contact_shapes_test")};
  for (int k = 0; k < 1500; ++k) {
    const auto size = [&] { return random.uniform(0.03, 0.3); };
    const double kind = random.uniform(), other = random.uniform();
    const Shape shape = kind < 0.25  ? make_sphere(size())
                        : kind < 0.5 ? make_cylinder(size(), size())
                        : kind < 0.8 ? make_capsule(size(), size())
                                     : make_box(size(), size(), size());
    Shape floor = other < 0.4   ? make_capsule(2.0 * size(), 3.0 * size())
                  : other < 0.6 ? make_plane()
                                : make_height_field(2.0, 2.0, 9, 9, [&](double, double) {
                                    return random.uniform(-0.1, 0.1);
                                  });
    if (other < 0.4) floor.pose.rotation = random.quaternion();
    Scenario scenario = world_on(floor, solid(random.uniform(0.05, 5.0), shape), {},
                                 random.uniform() < 0.5 ? 1e-3 : 2e-3);
    scenario.constants[kGravity + 2] = 0.0;
    scenario.constants[kDissipation] = random.uniform(0.1, 3.0);
    Bench bench(scenario);
    store(Vec3<double>{random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 1.3},
          bench.state.q.data());
    store(random.quaternion(), bench.state.q.data() + 3);
    store(Vec3<double>{0, 0, -random.uniform(0.5, 8.0)}, bench.state.u.data());
    for (int axis = 0; axis < 3; ++axis) bench.state.u[3 + axis] = random.uniform(-8.0, 8.0);
    bench.stepper->update_bodies(bench.state);
    const double before = energy(bench);
    for (int i = 0; i < 600; ++i) {
      ASSERT_TRUE(bench.run(1));
      // The midpoint rule keeps the energy of free spin to 1e-5 of itself; normals of hills jump
      // between their triangles.
      ASSERT_LT(energy(bench), before * (1.0 + (other < 0.6 ? 1e-4 : 1e-2)))
          << "flight " << k << " step " << i << " shape " << static_cast<int>(shape.type)
          << " floor " << static_cast<int>(floor.type);
    }
  }
}

}  // namespace
}  // namespace skybody::test
