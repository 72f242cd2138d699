// Bounding volumes: when bodies count as near each other or an obstacle.
#include "core/physics/step/reach.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

/// What Reach adds to every sphere [m].
constexpr double kMargin = 1e-3;

RobotModel ball(double radius, Vec3<double> center = {0, 0, 0}) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  model.bodies[0].collisions = {make_sphere(radius)};
  model.bodies[0].collisions[0].pose.position = center;
  return model;
}

Scenario two(RobotModel a, RobotModel b) {
  Scenario scenario = make_scenario(std::move(a));
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots[1].name = "s";
  scenario.robots[1].model = std::move(b);
  return scenario;
}

Scenario with_obstacle(RobotModel model, Shape shape) {
  Scenario scenario = make_scenario(std::move(model));
  scenario.obstacles.push_back({"obstacle", std::move(shape)});
  return scenario;
}

/// A world, where its bodies are, and whether they are within reach.
struct Scene {
  explicit Scene(Scenario scenario)
      : world(std::move(scenario)), reach(world), motion(world.bodies.size()) {
    for (std::size_t i = 0; i < motion.size(); ++i) place(i, {0, 0, 0});
  }
  void place(std::size_t body, Vec3<double> position, Quat<double> rotation = {1, 0, 0, 0}) {
    motion[body] = {position, rotation, to_mat3(rotation), {0, 0, 0}, {0, 0, 0}, {0.0, 0.0, 0.0}};
  }
  bool is_within() const {
    std::vector<SweptSphere<double>> swept(reach.sphere_count());
    return reach.is_within(motion.data(), swept.data());
  }
  /// Whether it is within reach a little less than `x` away along x, and no more a little farther.
  void expect_edge(std::size_t body, double x) {
    place(body, {x - 1e-9, 0, 0});
    EXPECT_TRUE(is_within()) << x;
    place(body, {x + 1e-9, 0, 0});
    EXPECT_FALSE(is_within()) << x;
  }

  const World world;
  const Reach reach;
  std::vector<BodyKinematics<double>> motion;
};

TEST(Reach, OfSpheresIsTheSumOfRadiiAndMargins) {
  Scene scene(two(ball(0.1), ball(0.2)));
  scene.expect_edge(1, 0.3 + 2 * kMargin);
  scene.place(1, {0, 0, 0});
  scene.expect_edge(0, 0.3 + 2 * kMargin);
}

TEST(Reach, TurnsWithTheBody) {
  Scene scene(two(ball(0.1), ball(0.2, {0, 0, 0.5})));
  scene.place(1, {0, 0, -0.5});
  EXPECT_TRUE(scene.is_within());
  scene.place(1, {0, 0, -0.5}, from_rpy(3.0, 0.0, 0.0));
  EXPECT_FALSE(scene.is_within());
}

TEST(Reach, HoldsAllShapesOfABody) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  Shape left = make_sphere(0.1), right = make_box(0.02, 0.06, 0.09), rim = make_cylinder(0.3, 0.8);
  left.pose.position.x = -0.7;
  right.pose.position.x = 0.5;
  model.bodies[0].collisions = {left, right, rim};
  Scene scene(two(ball(0.05), model));
  // Spheres of 0.1 m, 0.055 m and 0.5 m, from -0.8 m to 0.555 m.
  const double reach = 0.05 + 2 * kMargin;
  const double radius =
      0.5 * (0.8 + 0.5 * std::sqrt(0.02 * 0.02 + 0.06 * 0.06 + 0.09 * 0.09) + 0.5);
  scene.expect_edge(1, 0.8 + reach);
  EXPECT_GT(radius, 0.67);
  scene.place(1, {0.8 - 2 * radius - reach - 1e-9, 0, 0});
  EXPECT_FALSE(scene.is_within());
}

TEST(Reach, OfABoxEndsAtItsFacesEdgesAndCorners) {
  Shape box = make_box(0.4, 0.6, 2.0);
  box.pose = {{1, 0, 0}, from_rpy(0.0, 0.0, 0.5 * kPi)};  // its long side along x now
  Scene scene(with_obstacle(ball(0.1), box));
  const double reach = 0.1 + kMargin;
  scene.expect_edge(0, 1.0 + 0.3 + reach);
  scene.place(0, {1.3 + 0.7 * reach, 0.2 + 0.7 * reach, 0});
  EXPECT_TRUE(scene.is_within()) << "0.99 of the reach from an edge";
  scene.place(0, {1.3 + 0.72 * reach, 0.2 + 0.72 * reach, 0});
  EXPECT_FALSE(scene.is_within()) << "1.02 of the reach";
  scene.place(0, {1.3 + 0.57 * reach, 0.2 + 0.57 * reach, 1.0 + 0.57 * reach});
  EXPECT_TRUE(scene.is_within()) << "0.99 of the reach from a corner";
  scene.place(0, {1.3 + 0.59 * reach, 0.2 + 0.59 * reach, 1.0 + 0.59 * reach});
  EXPECT_FALSE(scene.is_within()) << "1.02 of the reach";
  scene.place(0, {1, 0, 0});
  EXPECT_TRUE(scene.is_within()) << "inside";
}

TEST(Reach, OfOtherObstacles) {
  Scene sphere(with_obstacle(ball(0.1), make_sphere(0.5)));
  sphere.expect_edge(0, 0.6 + kMargin);
  Scene cylinder(with_obstacle(ball(0.1), make_cylinder(0.5, 4.0)));
  cylinder.expect_edge(0, 0.6 + kMargin);
  Shape mesh;
  mesh.type = ShapeType::kMesh;
  EXPECT_FALSE(Scene(with_obstacle(ball(0.1), mesh)).reach.is_possible())
      << "Simbody's contact does not know meshes of files";
}

TEST(Reach, GrowsByTheWayOfOneStep) {
  Scene scene(two(ball(0.1), ball(0.2, {0, 0.5, 0})));
  const double dt = scene.world.scenario.stepping.dt;
  const double apart = 0.3 + 2 * kMargin;
  scene.place(1, {apart + 4.9 * dt, -0.5, 0});
  EXPECT_FALSE(scene.is_within());
  scene.motion[0].velocity = {3.0, 0, 0};
  scene.motion[1].velocity = {-2.0, 0, 0};
  EXPECT_TRUE(scene.is_within()) << "5 m/s towards each other";
  scene.motion[0].velocity = scene.motion[1].velocity = {0, 0, 0};
  scene.motion[1].angular_velocity = {0, 0, 10.0};
  EXPECT_TRUE(scene.is_within()) << "5 m/s of the second sphere's centre";
}

TEST(Reach, LeavesBodiesOfOneRobotAlone) {
  RobotModel model = ball(0.1);
  model.bodies.push_back(
      make_body("bob", JointType::kPin, 0, 0.2, {0, 0, 0}, diagonal(1e-3, 1e-3, 1e-3)));
  model.bodies[1].collisions = {make_sphere(0.1)};
  EXPECT_FALSE(Reach(World(make_scenario(model))).is_possible());
  Scene scene(two(model, ball(0.1)));
  scene.place(2, {5, 0, 0});
  EXPECT_FALSE(scene.is_within());
  scene.place(1, {4.9, 0, 0});
  EXPECT_TRUE(scene.is_within()) << "each link for itself";
}

TEST(Reach, IsImpossibleWithoutShapes) {
  const RobotModel bare = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  EXPECT_FALSE(Reach(World(two(bare, bare))).is_possible());
  EXPECT_FALSE(Reach(World(two(bare, ball(0.1)))).is_possible());
  EXPECT_FALSE(Reach(World(with_obstacle(bare, make_sphere(0.1)))).is_possible());
  EXPECT_TRUE(Reach(World(two(ball(0.1), ball(0.1)))).is_possible());
}

TEST(Reach, OfWhatIsNotFiniteIsNothing) {
  Scene robots(two(ball(0.1), ball(0.2))), wall(with_obstacle(ball(0.1), make_box(1, 1, 1)));
  for (Scene* scene : {&robots, &wall}) {
    EXPECT_TRUE(scene->is_within());
    scene->motion[0].position.y = kNan;
    EXPECT_FALSE(scene->is_within());
  }
}

/// The sphere of random shapes holds their extremities: nothing that touches is missed.
TEST(Reach, HoldsEveryExtremityOfRandomShapes) {
  for (std::uint64_t k = 0; k < 40; ++k) {
    Random<double> random{RandomKey{2026, 31}, k, 0, derive_stream("reach_test")};
    RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
    for (int i = 0; i < 3; ++i) {
      const auto size = [&] { return random.uniform(0.01, 0.5); };
      Shape shape = i == 0 ? make_sphere(size()) : make_cylinder(size(), size());
      if (i == 2) shape = make_box(size(), size(), size());
      shape.pose.position = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
      shape.pose.rotation = random.quaternion();
      model.bodies[0].collisions.push_back(shape);
    }
    Scene scene(two(ball(1e-3), model));
    scene.place(1, {1, 2, 3}, random.quaternion());
    for (const ContactSphere& extremity : scene.world.spheres) {
      if (extremity.body != 1) continue;
      const BodyKinematics<double>& body = scene.motion[1];
      scene.place(0, body.position + body.axes * extremity.center);
      ASSERT_TRUE(scene.is_within()) << k;
    }
  }
}

}  // namespace
}  // namespace skybody::test
