#include "core/physics/bodies/default_state.h"

#include <cmath>

#include "core/base/math/math.h"
#include "core/model/held_inputs.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/world/pose_math.h"

namespace skybody {
namespace {

/// Initial coordinates of a joint: those of the scenario, otherwise zero.
/// @param q  zeros, written
void write_position(const Joint& joint, double* q) {
  if (joint.type == JointType::kBall) q[0] = 1.0;
  if (joint.type == JointType::kFree) q[3] = 1.0;
  if (joint.type == JointType::kPin || joint.type == JointType::kSlider) q[0] = joint.position;
}

/// Initial coordinates of all joints; the base's frame B at the scenario's pose.
void write_positions(const World& world, LaneState& state) {
  for (const WorldBody& body : world.bodies) {
    double* q = state.q.data() + body.q;
    write_position(body.model->joint, q);
    if (body.model->joint.type != JointType::kFree || body.parent >= 0) continue;
    const Pose& pose = world.scenario.robots[body.robot].pose;
    store(pose.position, q);
    store(pose.rotation, q + 3);
  }
}

void write_rotors(const World& world, LaneState& state) {
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    state.rotor_speed[i] = state.rotor_command[i] = start_rotor_speed(world, static_cast<int>(i));
  }
}

/// Velocity drives start at rest, pose drives at the scenario's pose of the base.
void write_drives(const World& world, LaneState& state) {
  double* drive = state.drive.data();
  for (std::size_t r = 0; r < world.drives.size(); ++r) {
    if (world.drives[r] == DriveKind::kNone) continue;
    const Pose& pose = world.scenario.robots[r].pose;
    store(pose.position, drive + kDrivePosition);
    store(pose.rotation, drive + kDriveRotation);
    drive += kDriveSize;
  }
}

/// Position drives start at the joint positions; the others at zero.
void write_joint_drives(const World& world, LaneState& state) {
  for (std::size_t i = 0; i < world.joint_drives.size(); ++i) {
    const JointDrive& drive = world.joint_drives[i];
    if (drive.mode != JointMode::kPosition) continue;
    const int q = world.bodies[static_cast<std::size_t>(drive.body)].q + drive.coordinate;
    state.joint_command[i] = state.joint_state[i] = state.q[static_cast<std::size_t>(q)];
  }
}

}  // namespace

Pose place_at_reset(const RobotModel& model, int body) {
  constexpr double kRest[6] = {};
  Pose place;
  while (body > 0) {
    const Joint& joint = model.bodies[static_cast<std::size_t>(body)].joint;
    double q[7] = {};
    write_position(joint, q);
    const JointMotion<double> moved = joint_motion(joint.type, q, kRest);
    const Pose& own = joint.frame_in_body;
    const Pose back{-rotate_inverse(own.rotation, own.position), conjugate(own.rotation)};
    const Pose out = compose(joint.frame_in_parent, {moved.translation, moved.rotation});
    place = compose(compose(out, back), place);
    body = joint.parent;
  }
  return place;
}

double lift_of(const RobotModel& model, const Rotor& rotor) {
  constexpr double kLeast = 1e-6;  // smaller values are round-off
  const double z = rotate(place_at_reset(model, rotor.body).rotation, rotor.axis).z;
  return z > kLeast || (rotor.is_reversible() && z < -kLeast) ? z : 0.0;
}

double hover_rotor_speed(const Scenario& scenario, int robot) {
  const RobotModel& model = scenario.robots[static_cast<std::size_t>(robot)].model;
  double lift = 0.0;
  for (const Rotor& rotor : model.rotors) {
    lift += rotor.constants[kThrustConstant] * std::fabs(lift_of(model, rotor));
  }
  if (!(lift > 0.0)) return 0.0;
  return sqrt(model.total_mass() * norm(scenario.gravity()) / lift);
}

double start_rotor_speed(const Topology& world, int rotor) {
  const WorldRotor& r = world.rotors[static_cast<std::size_t>(rotor)];
  const RobotUse& robot = world.scenario.robots[static_cast<std::size_t>(r.robot)];
  double speed = robot.rotor_speed;
  if (speed < 0.0) {
    const double lift = lift_of(robot.model, *r.model);
    const double hover = lift == 0.0 ? 0.0 : hover_rotor_speed(world.scenario, r.robot);
    speed = lift < 0.0 ? max(-hover, r.model->min_speed) : hover;
  }
  return min(speed, r.model->constants[kMaxSpeed]);
}

LaneState make_lane_state(const World& world) {
  const StateLayout& layout = world.layout;
  LaneState state;
  for (const LaneBlock& b : kLaneBlocks) {
    (state.*b.values).assign(static_cast<std::size_t>((layout.*b.place).size), 0.0);
  }
  for (std::size_t i = 0; i < layout.held.size(); ++i) {
    state.held[i].clear();
    for (int k = 0; k < layout.held[i].size; ++k) {
      state.held[i].push_back(neutral_value(static_cast<int>(i), k % kHeldInputs[i].size));
    }
  }
  state.bodies.assign(world.bodies.size(), BodyState{});
  return state;
}

void write_default_state(const World& world, LaneState& state) {
  state = make_lane_state(world);
  for (std::size_t i = 0; i < state.params.size(); ++i) {
    state.params[i] = world.layout.param_info[i].nominal;
  }
  write_positions(world, state);
  write_rotors(world, state);
  write_drives(world, state);
  write_joint_drives(world, state);

  std::vector<BodyKinematics<double>> motion(world.bodies.size());
  forward_kinematics(make_tree(world), state.q.data(), state.u.data(), motion.data());
  for (std::size_t i = 0; i < motion.size(); ++i) state.bodies[i] = to_body_state(motion[i]);
}

}  // namespace skybody
