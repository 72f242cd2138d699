// Lying, leaning and standing bodies stay in place.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/physics/contact_worlds.h"

namespace skybody::test {
namespace {

/// Runs for a minute; no body's origin may move by more than `most`.
void expect_rest(Bench& bench, int bodies, double most) {
  const std::vector<double> rest = bench.state.q;
  for (int second = 1; second <= 60; ++second) {
    ASSERT_TRUE(bench.run_seconds(1.0));
    for (int b = 0; b < bodies; ++b) {
      const Vec3<double> now = load_vec3(bench.state.q.data() + 7 * b);
      ASSERT_LT(norm(now - load_vec3(rest.data() + 7 * b)), most) << second << " s, body " << b;
    }
  }
}

Vec3<double> force_from(Bench& bench, bool by_ground) {
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  Vec3<double> sum{0, 0, 0};
  for (const Contact& c : contacts) {
    if (by_ground ? c.other == kGround : is_obstacle(c.other)) sum += c.force;
  }
  return sum;
}

TEST(Stack, OfThreeBoxesRestsForAMinute) {
  Scenario scenario = world_of(solid(1.0, make_box(0.2, 0.2, 0.1)));
  scenario.robots[0].pose.position = {0, 0, 0.05};
  add_robot(scenario, "s", solid(1.0, make_box(0.2, 0.2, 0.1)), {{0.02, 0.01, 0.15}, {1, 0, 0, 0}});
  add_robot(scenario, "t", solid(1.0, make_box(0.2, 0.2, 0.1)),
            {{-0.02, 0.03, 0.25}, from_rpy(0.0, 0.0, 0.3)});
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(3.0));
  expect_rest(bench, 3, 1e-3);
  EXPECT_NEAR(force_from(bench, true).z, 3.0 * 9.81, 1e-3);
}

/// A QDrone2 with stopped rotors, one side on the ground and the other on a vertical wall. A plate
/// stays if tan(its angle) > (1 - mu^2) / (2 mu) = 0.53 with the friction mu = 0.6 at both ends:
/// from 28 degrees.
class Leaning : public testing::TestWithParam<double> {};

TEST_P(Leaning, AVehicleOnAWallRestsForAMinute) {
  Scenario scenario = world_of(make_vehicle(qdrone2()));
  add_box(scenario, "wall", {0.2, 4.0, 2.0}, {{0.3, 0.0, 1.0}, {1, 0, 0, 0}});  // its face: x = 0.2
  scenario.robots[0].pose = {{0.07, 0.0, 0.16}, from_rpy(0.01, -GetParam() * kPi / 180.0, 0.02)};
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(5.0));
  const auto pitch = [&] {
    const Vec3<double> forward = rotate(load_quat(bench.state.q.data() + 3), {1, 0, 0});
    return std::asin(forward.z) * 180.0 / kPi;
  };
  const double angle = pitch();
  ASSERT_GT(angle, 28.0) << "it leans";
  expect_rest(bench, 1, 1e-3);
  EXPECT_NEAR(pitch(), angle, 0.1);
  // Ground and wall carry the weight, and push against each other.
  const Vec3<double> ground = force_from(bench, true), wall = force_from(bench, false);
  EXPECT_NEAR(ground.z + wall.z, 1.54 * 9.81, 1e-3);
  EXPECT_NEAR(ground.x + wall.x, 0.0, 1e-3);
  EXPECT_GT(ground.z, 1.0);
  EXPECT_LT(wall.x, -1.0);
}

INSTANTIATE_TEST_SUITE_P(Angles, Leaning, testing::Values(45.0, 60.0));

/// A QDrone2 on its side, a face 50 mm wide and 0.35 m high. It turns easily about its supporting
/// edges, so the damping of contacts in line with the ground must be less than its mass alone would
/// allow.
class OnItsSide : public testing::TestWithParam<double> {};

TEST_P(OnItsSide, AVehicleRestsForAMinute) {
  for (const double lean : {0.0, 0.002, 0.02}) {
    for (const double side : {-1.0, 1.0}) {
      Scenario scenario = world_of(make_vehicle(qdrone2()), GetParam());
      const Quat<double> rotation = from_rpy(side * 0.5 * kPi + lean, 0.7 * lean, 0.3);
      scenario.robots[0].pose = {{0.0, 0.0, 0.18}, rotation};
      Bench bench(scenario);
      ASSERT_TRUE(bench.run_seconds(20.0));
      expect_rest(bench, 1, 1e-3);
      EXPECT_LT(norm(bench.state.bodies[0].velocity), 1e-6) << "lean " << lean;
      EXPECT_NEAR(bench.state.q[2], 0.174, 0.001) << "it lies on its side";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, OnItsSide, testing::Values(2.5e-4, 1e-3, 2e-3, 3e-3, 4e-3));

/// A can set down upright with a spin rests on all eight points of its rim at once.
class Upright : public testing::TestWithParam<double> {};

TEST_P(Upright, ACanRestsForAMinute) {
  Scenario scenario = world_of(solid(0.5, make_cylinder(0.05, 0.3)), GetParam());
  scenario.robots[0].pose.position.z = 0.151;
  Bench bench(scenario);
  bench.state.u[0] = 0.05;  // [m/s]
  bench.state.u[5] = 0.2;   // [rad/s]
  ASSERT_TRUE(bench.run_seconds(10.0));
  expect_rest(bench, 1, 1e-5);
  EXPECT_LT(norm(bench.state.bodies[0].angular_velocity), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Steps, Upright, testing::Values(2.5e-4, 1e-3, 2e-3, 3e-3, 4e-3));

/// On the corners of a smaller post, where no bristle holds: a plate that is set down with a spin,
/// and a QDrone2 on its side. They creep by less than 1 mm a minute, and do not rattle.
class OnAPost : public testing::TestWithParam<double> {};

TEST_P(OnAPost, WhatOverhangsLiesStill) {
  struct Case {
    RobotModel model;
    Quat<double> rotation;
    double half;  ///< of its height
    Vec3<double> post;
  };
  const Case cases[] = {
      {solid(1.0, make_box(0.3, 0.3, 0.03)), {1, 0, 0, 0}, 0.015, {0.25, 0.25, 0.2}},
      {make_vehicle(qdrone2()), from_rpy(0.5 * kPi, 0.0, 0.0), 0.175, {0.28, 0.04, 0.2}}};
  for (const Case& c : cases) {
    Scenario scenario = world_of(c.model, GetParam());
    scenario.contact.ground = false;
    add_box(scenario, "post", c.post, {{0, 0, 0.5 * c.post.z}, {1, 0, 0, 0}});
    scenario.robots[0].pose = {{0, 0, c.post.z + c.half + 0.001}, c.rotation};
    Bench bench(scenario);
    bench.state.u[0] = 0.05;  // [m/s]
    bench.state.u[5] = 0.2;   // [rad/s]
    ASSERT_TRUE(bench.run_seconds(10.0));
    expect_rest(bench, 1, 1e-3);
    EXPECT_LT(norm(bench.state.bodies[0].angular_velocity), 1e-6) << "half " << c.half;
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, OnAPost, testing::Values(2.5e-4, 1e-3, 2e-3, 4e-3));

/// A box on a slope below the angle of friction, by tilted gravity.
TEST(Slope, BelowTheAngleOfFrictionABoxStays) {
  Scenario scenario = world_of(solid(1.0, make_box(0.2, 0.2, 0.1)));
  const double angle = 0.5;  // tan 0.546, friction 0.6
  scenario.constants[kGravity] = 9.81 * std::sin(angle);
  scenario.constants[kGravity + 2] = -9.81 * std::cos(angle);
  scenario.robots[0].pose.position = {0, 0, 0.05};
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(3.0));
  expect_rest(bench, 1, 1e-5);
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

}  // namespace
}  // namespace skybody::test
