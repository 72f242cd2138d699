// Small robots built by hand, and helpers for tests of physics with them.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/math/math.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/world/world.h"
#include "tests/unit/physics/stepper.h"

namespace skybody::test {

/// The integrators with fixed steps.
inline constexpr IntegratorChoice kFixedSteps[] = {
    IntegratorChoice::kRk4, IntegratorChoice::kSemiImplicitEuler, IntegratorChoice::kMidpoint};

inline SymMat3<double> diagonal(double xx, double yy, double zz) { return {xx, yy, zz, 0, 0, 0}; }

inline Body make_body(const std::string& name, JointType type, int parent, double mass,
                      Vec3<double> com, SymMat3<double> inertia) {
  Body body;
  body.name = name;
  body.joint.name = name + "_joint";
  body.joint.type = type;
  body.joint.parent = parent;
  body.mass = {mass, com, inertia};
  return body;
}

inline Shape make_box(double x, double y, double z) {
  Shape shape;
  shape.type = ShapeType::kBox;
  shape.size = {x, y, z};
  return shape;
}

inline Shape make_sphere(double radius) {
  Shape shape;
  shape.type = ShapeType::kSphere;
  shape.radius = radius;
  return shape;
}

inline Shape make_cylinder(double radius, double length) {
  Shape shape;
  shape.type = ShapeType::kCylinder;
  shape.radius = radius;
  shape.length = length;
  return shape;
}

/// @param length  between the centres of its caps
inline Shape make_capsule(double radius, double length) {
  Shape shape;
  shape.type = ShapeType::kCapsule;
  shape.radius = radius;
  shape.length = length;
  return shape;
}

inline Shape make_plane() {
  Shape shape;
  shape.type = ShapeType::kPlane;
  return shape;
}

/// @param heights  height(x, y) of the corners of cells
template <class Height>
Shape make_height_field(double x, double y, int columns, int rows, const Height& height) {
  std::vector<double> heights;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      heights.push_back(height(x * (c / (columns - 1.0) - 0.5), y * (r / (rows - 1.0) - 0.5)));
    }
  }
  Shape shape;
  shape.type = ShapeType::kHeightField;
  shape.size = {x, y, 0.0};
  shape.heights = std::make_shared<HeightField>(columns, rows, std::move(heights));
  return shape;
}

/// One free body without rotors or shapes.
inline RobotModel make_free_body(double mass, SymMat3<double> inertia,
                                 Vec3<double> com = {0, 0, 0}) {
  RobotModel model;
  model.name = "free_body";
  model.bodies.push_back(make_body("base", JointType::kFree, -1, mass, com, inertia));
  return model;
}

/// The parameters of a simple vehicle. Shapes as in scenarios/models.
struct VehicleData {
  double mass;  ///< [kg]
  SymMat3<double> inertia;
  double arm;               ///< rotor hubs at (+-arm, +-arm) or on a circle of this radius [m]
  double kf, km;            ///< thrust and moment constants
  double max_speed;         ///< [rad/s]
  double tau_up, tau_down;  ///< [s]
  Vec3<double> box;         ///< collision box [m]
  int rotors = 4;
  double foot = 0.0;  ///< radius of spheres under the box's corners [m], 0: none
};

inline VehicleData qdrone2() {
  return {1.54,
          diagonal(0.0147, 0.0169, 0.0294),
          0.115,
          1.9533e-6,
          2.8401e-8,
          2246,
          0.0125,
          0.025,
          {0.30, 0.35, 0.05},
          4,
          0.01};
}
inline VehicleData crazyflie() {
  return {0.027,
          diagonal(1.6572e-5, 1.6656e-5, 2.9262e-5),
          0.031,
          1.28192e-8,
          7.646e-11,
          2618,
          0.0125,
          0.025,
          {0.045, 0.045, 0.03}};
}
inline VehicleData hummingbird() {
  return {0.716,
          diagonal(0.007, 0.007, 0.012),
          0.12,
          8.54858e-6,
          1.3678e-7,
          838,
          0.0125,
          0.025,
          {0.1, 0.1, 0.12}};
}
inline VehicleData firefly() {
  return {1.56,
          diagonal(0.03476, 0.04589, 0.066),
          0.215,
          8.54858e-6,
          1.3678e-7,
          838,
          0.0125,
          0.025,
          {0.1, 0.1, 0.16},
          6};
}

/// Height of the base's origin above its support [m].
inline double clearance(const VehicleData& d) { return 0.5 * d.box.z + 3.0 * d.foot; }

/// A multirotor with alternating rotors in the plane of its centre of mass and a box to land on.
inline RobotModel make_vehicle(const VehicleData& d) {
  RobotModel model = make_free_body(d.mass, d.inertia);
  model.bodies[0].collisions.push_back(make_box(d.box.x, d.box.y, d.box.z));
  for (int i = 0; i < 4 && d.foot > 0.0; ++i) {
    Shape foot = make_sphere(d.foot);
    foot.pose.position = {(i & 1 ? 0.34 : -0.34) * d.box.x, (i & 2 ? 0.36 : -0.36) * d.box.y,
                          -0.5 * d.box.z - 2.0 * d.foot};
    model.bodies[0].collisions.push_back(foot);
  }
  for (int i = 0; i < d.rotors; ++i) {
    const SinCos<double> at = sincos((i + 0.5) * kTwoPi / d.rotors);
    Rotor rotor;
    rotor.name = "rotor_" + std::to_string(i);
    rotor.set_position({d.arm * at.cos, d.arm * at.sin, 0.0});
    rotor.direction = i % 2 == 0 ? 1 : -1;
    rotor.constants[kThrustConstant] = d.kf;
    rotor.constants[kMomentConstant] = d.km;
    rotor.constants[kMaxSpeed] = d.max_speed;
    rotor.constants[kTauUp] = d.tau_up;
    rotor.constants[kTauDown] = d.tau_down;
    model.rotors.push_back(rotor);
  }
  return model;
}

inline Scenario make_scenario(RobotModel model,
                              IntegratorChoice integrator = IntegratorChoice::kSemiImplicitEuler,
                              double dt = 0.001) {
  Scenario scenario;
  scenario.name = "test";
  scenario.stepping.dt = dt;
  scenario.stepping.integrator = integrator;
  RobotUse use;
  use.name = "r";
  use.model = std::move(model);
  scenario.robots.push_back(std::move(use));
  return scenario;
}

/// A world as controllers would set it up: `prepare` may set sites and drives.
inline World make_world(Scenario scenario, const std::function<void(WorldPlan&)>& prepare = {}) {
  const Topology topology(std::move(scenario));
  WorldPlan plan(topology);
  if (prepare) prepare(plan);
  return World(topology, std::move(plan));
}

/// A world with its stepper and state.
struct Bench {
  explicit Bench(Scenario scenario, const std::function<void(WorldPlan&)>& prepare = {})
      : world(make_world(std::move(scenario), prepare)) {
    stepper = make_stepper(world);
    write_default_state(world, state);
  }

  double dt() const { return world.scenario.stepping.dt; }
  double& param(const std::string& path) { return state.params.at(world.layout.find_param(path)); }
  /// @returns false as soon as a step fails
  bool run(int steps) {
    for (int i = 0; i < steps; ++i) {
      if (!stepper->advance(state)) return false;
    }
    return true;
  }
  bool run_seconds(double seconds) { return run(static_cast<int>(std::lround(seconds / dt()))); }

  const World world;
  std::unique_ptr<Stepper> stepper;
  LaneState state;
};

/// Kinetic energy of one body [J].
inline double kinetic_energy(const BodyState& b, const MassProperties& m) {
  const Vec3<double> v = b.velocity + rotate(b.rotation, cross(b.angular_velocity, m.com));
  return 0.5 * m.mass * dot(v, v) + 0.5 * dot(b.angular_velocity, m.inertia * b.angular_velocity);
}

/// Angular momentum of one body about its centre of mass, W axes.
inline Vec3<double> spin_momentum(const BodyState& b, const MassProperties& m) {
  return rotate(b.rotation, m.inertia * b.angular_velocity);
}

inline Vec3<double> com_velocity(const BodyState& b, const MassProperties& m) {
  return b.velocity + rotate(b.rotation, cross(b.angular_velocity, m.com));
}

/// Times at which `value` crosses zero upwards while stepping, interpolated linearly.
inline std::vector<double> upward_crossings(Bench& bench, const std::function<double()>& value,
                                            int steps) {
  std::vector<double> times;
  double before = value();
  for (int i = 0; i < steps; ++i) {
    if (!bench.stepper->advance(bench.state)) break;
    const double now = value();
    if (before < 0.0 && now >= 0.0) times.push_back((i + before / (before - now)) * bench.dt());
    before = now;
  }
  return times;
}

/// Mean time between the first and the last of the crossings.
inline double mean_period(const std::vector<double>& times) {
  return (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

}  // namespace skybody::test
