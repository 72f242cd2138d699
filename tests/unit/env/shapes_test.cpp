// The shapes that plugins read, with ids, sizes, poses and the parameters of obstacles.
#include <gtest/gtest.h>

#include "core/model/located_error.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// Observes an obstacle by its parameters: present, position, rotation, size.
class See : public Task {
 public:
  inline static std::vector<ShapeInfo> seen;
  inline static std::vector<std::string> names;

  void configure(const Setup& setup) override {
    seen.clear();
    names.clear();
    for (const ShapeInfo& shape : setup.shapes()) {
      seen.push_back(shape);
      names.push_back(shape.name);
      if (shape.first_param >= 0) first_ = shape.first_param;
    }
    EXPECT_EQ(std::string(setup.params()[first_].path), "obstacles.door.present");
    setup.channel("door", "", 11, -kInfinity, kInfinity);
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    for (int k = 0; k < 11; ++k) out.observation.set(k, env.param(first_ + k));
  }

 private:
  int first_ = 0;
};

Shape make(ShapeType type, Vec3<double> size, double radius, double length, Vec3<double> at) {
  Shape shape;
  shape.type = type;
  shape.size = size;
  shape.radius = radius;
  shape.length = length;
  shape.pose.position = at;
  return shape;
}

TEST(Shapes, OfBodiesAndObstaclesAreSeenByPluginsWithTheirParameters) {
  InProcessFactory factory;
  factory.add<test::Direct>("direct");
  factory.add<See>("see");
  Scenario s;
  s.name = "test";
  RobotUse robot;
  robot.model = test::quadrotor();
  robot.pose.position.z = 5.0;
  robot.controllers.push_back(factory.use("direct", "direct"));
  for (const char* name : {"a", "b"}) {
    robot.name = name;
    robot.model.bodies[0].collisions = {make(ShapeType::kBox, {0.1, 0.2, 0.3}, 0, 0, {0, 0, 0.05}),
                                        make(ShapeType::kSphere, {}, 0.02, 0, {0.1, 0, 0})};
    s.robots.push_back(robot);
    robot.pose.position.x += 3.0;
  }
  s.obstacles = {{"post", make(ShapeType::kCylinder, {}, 0.2, 3.0, {9, 1, 1.5}), false, {}},
                 {"door", make(ShapeType::kBox, {1.0, 2.0, 0.1}, 0, 0, {7, 8, 9}), true, {}}};
  s.task = factory.use("see", "task");
  const CompiledScenario compiled(std::move(s), factory);

  EXPECT_EQ(See::names, (std::vector<std::string>{"base", "base", "base", "base", "post", "door"}));
  const auto expect = [](int id, int kind, int of_robot, int obstacle, Vec3<double> size) {
    const ShapeInfo& shape = See::seen[static_cast<std::size_t>(id)];
    EXPECT_EQ(shape.kind, kind) << id;
    EXPECT_EQ(shape.robot, of_robot) << id;
    EXPECT_EQ(shape.body, of_robot) << id;  // each robot has one body
    EXPECT_EQ(shape.obstacle, obstacle) << id;
    EXPECT_EQ(shape.first_param >= 0, obstacle >= 0) << id;
    for (int k = 0; k < 3; ++k) EXPECT_EQ(shape.size[k], (&size.x)[k]) << id;
  };
  expect(0, SKYBODY_BOX, 0, -1, {0.1, 0.2, 0.3});
  expect(1, SKYBODY_SPHERE, 0, -1, {0.02, 0, 0});
  expect(3, SKYBODY_SPHERE, 1, -1, {0.02, 0, 0});
  expect(4, SKYBODY_CYLINDER, -1, 0, {0.2, 3.0, 0});
  expect(5, SKYBODY_GATE, -1, 1, {1.0, 2.0, 0.1});
  EXPECT_EQ(See::seen[0].position[2], 0.05);
  EXPECT_EQ(See::seen[4].position[0], 9.0);

  Flight flight(compiled, 1);
  flight.reset();
  EXPECT_EQ(flight.observation, (std::vector<float>{1, 7, 8, 9, 1, 0, 0, 0, 1.0f, 2.0f, 0.1f}));
}

/// Lists the shapes to draw.
class Draw : public Sensor {
 public:
  struct State {};
  inline static std::vector<VisualInfo> seen;

  void configure(const Setup& setup) override {
    seen.assign(setup.visuals().begin(), setup.visuals().end());
    setup.channel("count", "", 1, 0.0, kInfinity);
  }
  void sense(const EnvView<double>&, State&, Values<double> out) const { out.set(0, 0.0); }
};

TEST(Shapes, ToDrawAreTheVisualsOfABodyOrElseItsCollisionShapes) {
  InProcessFactory factory;
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<Draw>("draw");
  Scenario s;
  RobotUse robot;
  robot.model = test::quadrotor();
  robot.pose.position.z = 5.0;
  robot.controllers.push_back(factory.use("direct", "direct"));
  const Shape sphere = make(ShapeType::kSphere, {}, 0.02, 0, {0.1, 0, 0});
  Shape red = make(ShapeType::kBox, {0.1, 0.2, 0.3}, 0, 0, {0, 0, 0.05});
  red.rgba = {1.0, 0.0, 0.25, 1.0};
  Shape mesh = red;
  mesh.type = ShapeType::kMesh;
  const std::vector<Shape> visuals[] = {{}, {red, sphere}, {mesh}};
  for (const char* name : {"bare", "painted", "meshed"}) {
    robot.name = name;
    robot.model.bodies[0].collisions = {sphere};
    robot.model.bodies[0].visuals = visuals[s.robots.size()];
    s.robots.push_back(robot);
    robot.pose.position.x += 3.0;
  }
  s.sensors.push_back(factory.use("draw", "draw"));
  s.task = factory.use("watch", "task");
  const CompiledScenario compiled(std::move(s), factory);

  const auto expect = [](std::size_t id, int robot_index, int kind, double green) {
    const VisualInfo& visual = Draw::seen.at(id);
    EXPECT_EQ(visual.shape.robot, robot_index) << id;
    EXPECT_EQ(visual.shape.body, robot_index) << id;  // each robot has one body
    EXPECT_EQ(visual.shape.kind, kind) << id;
    EXPECT_EQ(visual.color[1], green) << id;
  };
  ASSERT_EQ(Draw::seen.size(), 4u);
  expect(0, 0, SKYBODY_SPHERE, 0.5);
  expect(1, 1, SKYBODY_BOX, 0.0);
  expect(2, 1, SKYBODY_SPHERE, 0.5);
  expect(3, 2, SKYBODY_SPHERE, 0.0);  // in the colour of the mesh, which is not read
  EXPECT_EQ(Draw::seen[1].shape.size[2], 0.3);
}

}  // namespace
}  // namespace skybody
