// Worlds of single solids, for tests of contact.
#pragma once

#include <string>
#include <utility>

#include "tests/unit/physics/test_models.h"

namespace skybody::test {

/// A free body of one shape, its mass spread evenly.
inline RobotModel solid(double mass, const Shape& shape) {
  double i = 0.4 * mass * 1e-4;
  if (shape.type == ShapeType::kSphere) i = 0.4 * mass * shape.radius * shape.radius;
  SymMat3<double> inertia = diagonal(i, i, i);
  const Vec3<double>& s = shape.size;
  if (shape.type == ShapeType::kBox) {
    const double m = mass / 12.0;
    inertia = diagonal(m * (s.y * s.y + s.z * s.z), m * (s.x * s.x + s.z * s.z),
                       m * (s.x * s.x + s.y * s.y));
  }
  if (shape.type == ShapeType::kCylinder) {
    const double r2 = shape.radius * shape.radius, l2 = shape.length * shape.length;
    const double across = mass * (3.0 * r2 + l2) / 12.0;
    inertia = diagonal(across, across, 0.5 * mass * r2);
  }
  if (shape.type == ShapeType::kCapsule) {  // two halves of a ball, and a cylinder between them
    const double r = shape.radius, l = shape.length, ball = 4.0 / 3.0 * r / (l + 4.0 / 3.0 * r);
    const double caps = ball * mass, rod = mass - caps;
    const double across =
        rod * (3.0 * r * r + l * l) / 12.0 + caps * (0.4 * r * r + 0.375 * r * l + 0.25 * l * l);
    inertia = diagonal(across, across, 0.5 * rod * r * r + 0.4 * caps * r * r);
  }
  RobotModel model = make_free_body(mass, inertia);
  model.bodies[0].collisions = {shape};
  return model;
}

inline Scenario world_of(RobotModel model, double dt = 1e-3) {
  return make_scenario(std::move(model), IntegratorChoice::kMidpoint, dt);
}

inline void add_robot(Scenario& scenario, const std::string& name, RobotModel model, Pose pose) {
  RobotUse use;
  use.name = name;
  use.model = std::move(model);
  use.pose = pose;
  scenario.robots.push_back(std::move(use));
}

inline void switch_off_gravity_and_ground(Scenario& scenario) {
  scenario.constants[kGravity + 2] = 0.0;
  scenario.contact.ground = false;
}

inline double energy(const Bench& bench) {
  double sum = 0.0;
  for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
    const MassProperties& m = bench.world.bodies[i].model->mass;
    sum += kinetic_energy(bench.state.bodies[i], m) +
           m.mass * -bench.world.scenario.gravity().z * bench.state.bodies[i].position.z;
  }
  return sum;
}

}  // namespace skybody::test
