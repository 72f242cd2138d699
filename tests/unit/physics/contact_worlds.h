// Worlds of single bodies for tests of contact, and groups of lanes that fly side by side.
#pragma once

#include <string>
#include <utility>

#include "core/base/system/error.h"
#include "tests/unit/physics/lane_groups.h"
#include "tests/unit/physics/random_trees.h"

namespace skybody::test {

/// A free body of one shape with uniform density.
inline RobotModel solid(double mass, const Shape& shape) {
  SymMat3<double> inertia = diagonal(0, 0, 0);
  const Vec3<double>& s = shape.size;
  const double r2 = shape.radius * shape.radius, l2 = shape.length * shape.length;
  switch (shape.type) {
    case ShapeType::kBox: {
      const double m = mass / 12.0;
      inertia = diagonal(m * (s.y * s.y + s.z * s.z), m * (s.x * s.x + s.z * s.z),
                         m * (s.x * s.x + s.y * s.y));
      break;
    }
    case ShapeType::kCylinder: {
      const double across = mass * (3.0 * r2 + l2) / 12.0;
      inertia = diagonal(across, across, 0.5 * mass * r2);
      break;
    }
    case ShapeType::kCapsule: {  // two halves of a ball, and a cylinder between them
      const double r = shape.radius, l = shape.length, ball = 4.0 / 3.0 * r / (l + 4.0 / 3.0 * r);
      const double caps = ball * mass, rod = mass - caps;
      const double across =
          rod * (3.0 * r2 + l2) / 12.0 + caps * (0.4 * r2 + 0.375 * r * l + 0.25 * l2);
      inertia = diagonal(across, across, 0.5 * rod * r2 + 0.4 * caps * r2);
      break;
    }
    default:
      inertia = diagonal(0.4 * mass * r2, 0.4 * mass * r2, 0.4 * mass * r2);
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

inline void add_box(Scenario& scenario, const std::string& name, Vec3<double> size, Pose pose) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.shape = make_box(size.x, size.y, size.z);
  obstacle.shape.pose = pose;
  scenario.obstacles.push_back(std::move(obstacle));
}

inline void switch_off_gravity_and_ground(Scenario& scenario) {
  scenario.constants[kGravity + 2] = 0.0;
  scenario.contact.ground = false;
}

/// Kinetic and gravitational energy of a free body whose origin is its centre of mass [J].
inline double energy_of(const BodyState& body, const World& world) {
  const MassProperties& m = world.bodies[0].model->mass;
  return kinetic_energy(body, m) - m.mass * dot(world.scenario.gravity(), body.position);
}

/// The energy of all bodies of a bench.
inline double energy(const Bench& bench) {
  double sum = 0.0;
  for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
    const MassProperties& m = bench.world.bodies[i].model->mass;
    sum += kinetic_energy(bench.state.bodies[i], m) +
           m.mass * -bench.world.scenario.gravity().z * bench.state.bodies[i].position.z;
  }
  return sum;
}

/// A group of lanes of one world with one free robot.
class LaneTries {
 public:
  explicit LaneTries(Scenario scenario)
      : world(make_world(std::move(scenario))), physics_(world), group_(world, physics_) {
    write_default_state(world, nominal);
  }

  void set(int lane, const LaneState& state) { group_.set(lane, state); }
  /// Call it after all lanes are set.
  void begin() { group_.refresh(kAllLanes); }
  /// One physics step. @returns true if no lane failed
  bool advance() { return group_.advance(kAllLanes) == kAllLanes; }
  /// True if any object was near enough to touch in the last step.
  bool was_near(int lane) const { return (group_.stepper->near() >> lane & 1u) != 0; }
  BodyState body(int lane) {
    const auto value = [&](Block StateLayout::*block, int k) {
      return group_.values_at(block)[static_cast<std::size_t>(k * kGroupLanes + lane)];
    };
    const auto vector = [&](Block StateLayout::*block, int k) {
      return Vec3<double>{value(block, k), value(block, k + 1), value(block, k + 2)};
    };
    return {vector(&StateLayout::q, 0),
            {value(&StateLayout::q, 3), value(&StateLayout::q, 4), value(&StateLayout::q, 5),
             value(&StateLayout::q, 6)},
            vector(&StateLayout::u, 0),
            vector(&StateLayout::u, 3)};
  }
  /// Index of a parameter in LaneState::params.
  std::size_t place(const std::string& path) const {
    const int found = world.layout.find_param(path);
    if (found < 0) throw Error("no parameter " + path);
    return static_cast<std::size_t>(found);
  }

  const World world;
  LaneState nominal;  ///< the state of a reset that draws nothing

 private:
  GroupPhysics physics_;
  PackGroup group_;
};

}  // namespace skybody::test
