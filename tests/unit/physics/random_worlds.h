// Random worlds of random robots, and values for their lanes: they cover all features of the tree
// engine.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/held_inputs.h"
#include "tests/unit/physics/random_trees.h"

namespace skybody::test {

/// Adds springs and limits to joints, and rotors with every effect to two of the bodies.
inline RobotModel busy(RobotModel model, Random<double>& random) {
  for (Body& body : model.bodies) {
    if (random.uniform() < 0.5) body.collisions.push_back(make_box(0.2, 0.1, 0.15));
    if (body.joint.parent < 0 || random.uniform() < 0.5) continue;
    body.joint.constants[kJointDamping] = 0.01;
    body.joint.constants[kJointStiffness] = 2.0;
    body.joint.limit = {true, -0.2, 0.2};
    body.joint.constants[kLimitStiffness] = 50.0;
    body.joint.constants[kLimitDamping] = 0.1;
  }
  for (int i = 0; i < 4; ++i) {
    Rotor rotor;
    rotor.name = "rotor_" + std::to_string(i);
    rotor.body = random.uniform() < 0.7 ? 0 : static_cast<int>(model.bodies.size()) - 1;
    rotor.set_position(in_cube(random, 0.2));
    rotor.axis = random.uniform() < 0.5 ? Vec3<double>{0, 0, 1}
                                        : rotate(random.quaternion(), Vec3<double>{0, 0, 1});
    rotor.direction = i % 2 == 0 ? 1 : -1;
    rotor.constants[kThrustConstant] = 2e-6;
    rotor.constants[kMomentConstant] = 3e-8;
    rotor.constants[kDragConstant] = random.uniform() < 0.5 ? 2e-5 : 0.0;
    rotor.constants[kRollingMomentConstant] = random.uniform() < 0.5 ? 1e-6 : 0.0;
    rotor.constants[kRotorInertia] = random.uniform() < 0.5 ? 5e-6 : 0.0;
    rotor.constants[kMaxSpeed] = 2200.0;
    rotor.constants[kTauUp] = random.uniform() < 0.2 ? 0.0 : 0.0125;
    rotor.constants[kTauDown] = 0.025;
    model.rotors.push_back(rotor);
  }
  return model;
}

inline LaneState random_lane(Random<double>& random, const World& world, bool drawn) {
  LaneState state;
  write_default_state(world, state);
  state.params = nominal_params(world);
  random_state(random, world, state.q, state.u);
  if (world.bodies[0].model->joint.type == JointType::kFree) {
    state.q[2] = random.uniform(-0.05, 1.0);  // some touch the ground
  }
  for (double& w : state.rotor_speed) w = random.uniform(0.0, 1500.0);
  for (double& w : state.rotor_command) w = random.uniform(-100.0, 3000.0);
  for (double& f : state.wrench) f = random.uniform(-1.0, 1.0);
  for (double& r : state.joint_command) r = random.uniform(-1.0, 1.0);
  for (double& r : state.joint_state) r = random.uniform(-1.0, 1.0);
  for (double& v : state.held[SKYBODY_HELD_WIND]) v = random.uniform(-5.0, 5.0);
  for (double& f : state.held[SKYBODY_HELD_WRENCH]) f = max(0.0, random.uniform(-1.0, 1.0));
  for (double& c : state.held[SKYBODY_HELD_BODY_DRAG]) c = max(0.0, random.uniform(-0.05, 0.05));
  for (double& g : state.held[SKYBODY_HELD_ROTOR_GAIN]) g = random.uniform(0.0, 2.0);
  for (double& w : state.held[SKYBODY_HELD_ROTOR_LIMIT]) w += random.uniform(0.0, 300.0);
  for (double& r : state.held[SKYBODY_HELD_ROTOR_RATE]) {
    if (random.uniform() < 0.5) r = random.uniform(-4000.0, 4000.0);
  }
  if (!drawn) return state;
  for (double& p : state.params) p *= random.uniform(0.95, 1.05);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {  // some are 0
    const int count = joint_constant_count(world.bodies[i].model->joint);
    for (int k = 0; k < count; ++k) {
      state.params[static_cast<std::size_t>(world.layout.joint_params[i] + k)] +=
          max(0.0, random.uniform(-0.5, 0.5));
    }
  }
  return state;
}

/// A drive of random mode in every joint that may have one.
inline std::vector<JointDrive> drives_for(Random<double>& random, const Topology& world) {
  std::vector<JointDrive> drives;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const JointType type = world.bodies[i].model->joint.type;
    if (type == JointType::kBall || type == JointType::kFree) continue;
    for (int k = 0; k < velocity_size(type); ++k) {
      const auto mode = static_cast<JointMode>(static_cast<int>(random.uniform() * 3.0));
      drives.push_back({static_cast<int>(i), k, mode, random.uniform(), random.uniform(),
                        random.uniform(), random.uniform() < 0.5 ? 0.0 : 0.01});
    }
  }
  return drives;
}

/// Two or three robots, sometimes beside an obstacle.
inline Scenario several(Random<double>& random, IntegratorChoice integrator) {
  Scenario scenario = make_scenario(busy(random_tree(random), random), integrator);
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots[1].model = busy(make_vehicle(qdrone2()), random);
  scenario.robots[1].name = "s";
  scenario.robots[2].model = make_vehicle(crazyflie());
  scenario.robots[2].name = "t";
  if (random.uniform() < 0.5) scenario.robots.pop_back();
  if (random.uniform() < 0.5) return scenario;
  scenario.obstacles.push_back({"wall", make_box(0.5, 3.0, 3.0)});
  scenario.obstacles[0].shape.pose.position = {4.0, 0.0, 0.0};
  return scenario;
}

}  // namespace skybody::test
