// Ground contact, and contact of robots and obstacles with each other.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

TEST(Ground, VehiclesRestStillWithinTheStaticPenetration) {
  for (const VehicleData& data : {qdrone2(), crazyflie(), hummingbird(), firefly()}) {
    Scenario scenario = make_scenario(make_vehicle(data));
    scenario.robots[0].pose.position = {0, 0, clearance(data) + 0.02};
    scenario.robots[0].pose.rotation = from_rpy(0.02, -0.03, 0.5);
    Bench bench(std::move(scenario));
    ASSERT_TRUE(bench.run_seconds(20.0));  // a Firefly rocks for long on its narrow foot
    const double height = bench.state.q[2];
    // 1 mm by definition of the stiffness; Hertz' law splits it evenly over four corners.
    EXPECT_NEAR(clearance(data) - height, 0.001, 1e-5) << data.mass << " kg";
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(bench.run(1));
      ASSERT_LT(norm(bench.state.bodies[0].velocity), 1e-6) << data.mass << " kg";
      ASSERT_LT(norm(bench.state.bodies[0].angular_velocity), 1e-5) << data.mass << " kg";
    }
    EXPECT_NEAR(bench.state.q[2], height, 1e-7);
  }
}

TEST(Ground, VehicleUpsideDownRestsToo) {
  const VehicleData data = crazyflie();
  Scenario scenario = make_scenario(make_vehicle(data));
  scenario.robots[0].pose = {{0, 0, 0.5}, from_rpy(3.0, 0.3, 0.5)};
  Bench bench(std::move(scenario));
  ASSERT_TRUE(bench.run_seconds(10.0));
  EXPECT_NEAR(bench.state.q[2], 0.5 * data.box.z - 0.001, 1e-4);
  EXPECT_LT(norm(bench.state.bodies[0].velocity), 1e-5);
}

TEST(Ground, SlidingBoxSlowsDownByFrictionAndStops) {
  RobotModel model = make_free_body(1.5, diagonal(0.02, 0.02, 0.03));
  model.bodies[0].collisions = {make_box(0.5, 0.5, 0.02)};
  Scenario scenario = make_scenario(model);
  scenario.robots[0].pose.position = {0, 0, 0.009};
  Bench bench(std::move(scenario));
  bench.state.u[0] = 2.0;
  ASSERT_TRUE(bench.run_seconds(0.2));
  EXPECT_NEAR(bench.state.u[0], 2.0 - 0.6 * 9.81 * 0.2, 0.01);
  ASSERT_TRUE(bench.run_seconds(2.0));
  EXPECT_NEAR(bench.state.u[0], 0.0, 1e-6);
  const double way = 4.0 / (2.0 * 0.6 * 9.81);
  EXPECT_NEAR(bench.state.q[0], way, 0.02 * way);
}

TEST(Ground, BouncesLoseEnergy) {
  RobotModel model = make_free_body(0.5, diagonal(1e-3, 1e-3, 1e-3));
  model.bodies[0].collisions = {make_sphere(0.05)};
  for (const double dissipation : {0.0, 0.3, 1.0}) {
    Scenario scenario = make_scenario(model);
    scenario.constants[kDissipation] = dissipation;
    scenario.robots[0].pose.position = {0, 0, 0.55};
    Bench bench(std::move(scenario));
    double last_top = 0.5, top = 0.0;
    bool rising = false;
    int bounces = 0;
    for (int i = 0; i < 3000; ++i) {
      ASSERT_TRUE(bench.run(1));
      const bool now_rising = bench.state.u[2] > 0.0;
      if (now_rising) top = bench.state.q[2] - 0.05;
      if (rising && !now_rising && top > 0.01) {
        ++bounces;
        // Without dissipation a symplectic step keeps the energy up to its own order (w h / 2).
        EXPECT_LT(top, last_top * (dissipation > 0.0 ? 1.0 : 1.05)) << dissipation;
        last_top = top;
      }
      rising = now_rising;
    }
    EXPECT_GE(bounces, 1) << dissipation;
  }
}

TEST(Ground, TumblingFallsGainNoEnergy) {
  const VehicleData data = qdrone2();
  for (int drop = 0; drop < 40; ++drop) {
    Scenario scenario = make_scenario(make_vehicle(data));
    scenario.robots[0].pose = {{0, 0, 10.0}, from_rpy(0.16 * drop, 0.4 * drop, 0.0)};
    Bench bench(std::move(scenario));
    for (int axis = 0; axis < 3; ++axis) bench.state.u[3 + axis] = 6.0 - (drop * (axis + 3)) % 12;
    const BodyState start = bench.state.bodies[0];
    const double spin = norm(start.angular_velocity);
    const double impact = sqrt(2.0 * 9.81 * 10.0) + spin * 0.5;  // of any point of the vehicle
    for (int i = 0; i < 10000; ++i) {
      ASSERT_TRUE(bench.run(1)) << drop;
      ASSERT_LT(norm(bench.state.bodies[0].velocity), impact) << drop << ' ' << i;
    }
    EXPECT_LT(norm(bench.state.bodies[0].velocity), 0.1 * impact) << drop;
  }
}

TEST(Ground, CanBeSwitchedOff) {
  Scenario scenario = make_scenario(make_vehicle(crazyflie()));
  scenario.contact.ground = false;
  Bench bench(std::move(scenario));
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_LT(bench.state.q[2], -4.0);
}

Scenario two_robots(RobotModel a, RobotModel b, Vec3<double> place_b) {
  Scenario scenario = make_scenario(std::move(a));
  scenario.constants[kGravity + 2] = 0.0;
  scenario.contact.ground = false;
  RobotUse other;
  other.name = "s";
  other.model = std::move(b);
  other.pose.position = place_b;
  scenario.robots.push_back(std::move(other));
  return scenario;
}

void expect_momentum_exchange(Shape a, Shape b) {
  RobotModel first = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  RobotModel second = make_free_body(0.5, diagonal(0.01, 0.01, 0.01));
  first.bodies[0].collisions = {a};
  second.bodies[0].collisions = {b};
  Bench bench(two_robots(first, second, {0.4, 0.01, 0.0}));
  bench.state.u[0] = 1.0;
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_GT(bench.state.u[6], 0.2) << "the second robot was pushed";
  EXPECT_LT(bench.state.u[0], 0.8);
  EXPECT_GT(bench.state.q[7], bench.state.q[0]) << "they did not pass through each other";
  // Contact forces are equal and opposite: rounding only.
  EXPECT_NEAR(1.0 * bench.state.u[0] + 0.5 * bench.state.u[6], 1.0, 1e-11);
  const double energy =
      0.5 * bench.state.u[0] * bench.state.u[0] + 0.25 * bench.state.u[6] * bench.state.u[6];
  EXPECT_LT(energy, 0.5);
}

TEST(Robots, CollidingSpheresExchangeMomentum) {
  expect_momentum_exchange(make_sphere(0.1), make_sphere(0.1));
}
TEST(Robots, CollidingBoxesExchangeMomentum) {
  expect_momentum_exchange(make_box(0.2, 0.2, 0.1), make_box(0.2, 0.2, 0.1));
}
TEST(Robots, SphereAndCylinderExchangeMomentum) {
  expect_momentum_exchange(make_sphere(0.1), make_cylinder(0.1, 0.2));
}

TEST(Robots, ContactDependsOnTheStateAlone) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  model.bodies[0].collisions = {make_box(0.2, 0.2, 0.1), make_sphere(0.11)};
  Bench a(two_robots(model, model, {0.4, 0.01, 0.0})), b(two_robots(model, model, {0.4, 0.01, 0}));
  a.state.u[0] = 1.0;
  ASSERT_TRUE(a.run(200));  // contact has begun at 0.18 s
  const LaneState saved = a.state;
  ASSERT_GT(saved.u[6], 0.0);
  ASSERT_TRUE(a.run(100));
  ASSERT_TRUE(b.run(50));
  b.state = saved;
  ASSERT_TRUE(b.run(100));
  EXPECT_EQ(a.state.q, b.state.q);
  EXPECT_EQ(a.state.u, b.state.u);
}

TEST(Robots, BodiesOfOneRobotDoNotCollide) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  model.bodies.push_back(
      make_body("second", JointType::kPin, 0, 0.5, {0, 0, 0}, diagonal(0.01, 0.01, 0.01)));
  for (Body& body : model.bodies) body.collisions = {make_sphere(0.1)};
  Bench bench(two_robots(model, make_free_body(1.0, diagonal(0.01, 0.01, 0.01)), {5, 0, 0}));
  std::vector<double> udot(bench.state.u.size());
  bench.stepper->accelerations(bench.state, udot.data());
  for (const double a : udot) EXPECT_NEAR(a, 0.0, 1e-12);
}

TEST(Obstacle, StopsARobot) {
  for (const Shape& shape : {make_sphere(0.1), make_box(0.2, 0.2, 0.2)}) {
    RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
    model.bodies[0].collisions = {shape};
    Scenario scenario = make_scenario(model);
    scenario.constants[kGravity + 2] = 0.0;
    scenario.contact.ground = false;
    Obstacle wall;
    wall.name = "wall";
    wall.shape = make_box(0.2, 1.0, 1.0);
    wall.shape.pose.position = {0.5, 0.0, 0.0};
    scenario.obstacles.push_back(wall);
    Bench bench(std::move(scenario));
    bench.state.u[0] = 1.0;
    double farthest = 0.0;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(bench.run(1));
      farthest = std::fmax(farthest, bench.state.q[0]);
    }
    EXPECT_LT(farthest, 0.35) << "the wall begins where the robot's origin is at 0.3";
    EXPECT_LT(bench.state.u[0], 0.0) << "thrown back";
    EXPECT_GT(bench.state.u[0], -1.0) << "with less energy";
  }
}

}  // namespace
}  // namespace skybody::test
