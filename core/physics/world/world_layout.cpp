#include "core/physics/world/world_layout.h"

#include <algorithm>
#include <span>

#include "core/model/held_inputs.h"

namespace skybody {
namespace {

/// Appends the first values of a table as EnvParams, as many as `nominal` has.
/// @param alias  another path; empty: none
/// @returns the index of the first
int add_constants(StateLayout& layout, const std::string& path, std::span<const ConstantRow> rows,
                  std::span<const double> nominal, const std::string& alias = "") {
  const int first = static_cast<int>(layout.param_info.size());
  for (const ConstantRow& row : rows) {
    if (row.place >= static_cast<int>(nominal.size())) break;
    const int given = static_cast<int>(nominal.size()) - row.place;
    for (int k = 0; k < std::min(row.count, given); ++k) {
      const std::string key = row.key + (row.count == 1 ? "" : "[" + std::to_string(k) + "]");
      add_param(layout, {path + key, row.unit, nominal[static_cast<std::size_t>(row.place + k)],
                         row.least_drawn(k), kInfinity, alias.empty() ? "" : alias + key});
    }
  }
  return first;
}

/// Values of kObstacleConstants, as many as the shape's dimensions need.
std::vector<double> obstacle_constants(const Shape& shape) {
  const Vec3<double>&p = shape.pose.position, &size = shape.size;
  const Quat<double>& q = shape.pose.rotation;
  std::vector<double> values{1.0, p.x, p.y, p.z, q.w, q.x, q.y, q.z};
  switch (shape.type) {
    case ShapeType::kBox:
      values.insert(values.end(), {size.x, size.y, size.z});
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCapsule:
      values.insert(values.end(), {shape.radius, shape.length});
      break;
    case ShapeType::kSphere:
      values.push_back(shape.radius);
      break;
    case ShapeType::kHeightField:
      values.insert(values.end(), {size.x, size.y});
      break;
    case ShapeType::kPlane:
    case ShapeType::kMesh:
      break;
  }
  return values;
}

/// The EnvParams of a world.
void add_physical_constants(StateLayout& layout, const Topology& world) {
  const std::vector<RobotUse>& robots = world.scenario.robots;
  const auto path_of = [&](int robot) {
    return "robots." + robots[static_cast<std::size_t>(robot)].name + ".";
  };
  for (const WorldBody& body : world.bodies) {
    const std::string path = path_of(body.robot) + "links." + body.model->name + ".";
    layout.body_params.push_back(
        add_constants(layout, path, kBodyConstants, body_constants(body.model->mass)));
  }
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    const WorldRotor& rotor = world.rotors[i];
    const int index =
        static_cast<int>(i) - layout.robots[static_cast<std::size_t>(rotor.robot)].first_rotor;
    const std::string path = path_of(rotor.robot) + "rotors[" + std::to_string(index) + "].";
    layout.rotor_params.push_back(
        add_constants(layout, path, kRotorConstants, rotor.model->constants,
                      path_of(rotor.robot) + "rotors." + rotor.model->name + "."));
  }
  for (const RobotUse& robot : robots) {
    layout.robot_params.push_back(
        add_constants(layout, "robots." + robot.name + ".", kRobotConstants, robot.constants));
  }
  int joints = 0, robot_of_joints = -1;
  for (const WorldBody& body : world.bodies) {
    if (body.robot != robot_of_joints) joints = 0;
    robot_of_joints = body.robot;
    const Joint& joint = body.model->joint;
    const std::string index = "joints[" + std::to_string(joints) + "].";
    joints += is_moving_joint(joint) ? 1 : 0;
    const auto count = static_cast<std::size_t>(joint_constant_count(joint));
    layout.joint_params.push_back(
        add_constants(layout, path_of(body.robot) + "joints." + joint.name + ".", kJointConstants,
                      std::span(joint.constants).first(count), path_of(body.robot) + index));
  }
  layout.world_params = add_constants(layout, "", kWorldConstants, world.scenario.constants);
  for (const Obstacle& obstacle : world.scenario.obstacles) {
    layout.obstacle_params.push_back(add_constants(layout, "obstacles." + obstacle.name + ".",
                                                   kObstacleConstants,
                                                   obstacle_constants(obstacle.shape)));
  }
  for (const Coupling& coupling : world.scenario.couplings) {
    const auto count = static_cast<std::size_t>(coupling_constant_count(coupling.kind));
    layout.coupling_params.push_back(add_constants(layout, "couplings." + coupling.name + ".",
                                                   kCouplingConstants,
                                                   std::span(coupling.constants).first(count)));
  }
  layout.physics_params = static_cast<int>(layout.param_info.size());
}

/// Ranges of one robot's coordinates.
RobotLayout make_robot_layout(const Topology& world, int robot) {
  RobotLayout out;
  bool found = false;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const WorldBody& body = world.bodies[i];
    if (body.robot != robot) continue;
    if (!found) {
      out.first_body = static_cast<int>(i);
      out.first_q = body.q;
      out.first_u = body.u;
      found = true;
    }
    ++out.body_count;
    out.q_count += position_size(body.model->joint.type);
    out.u_count += velocity_size(body.model->joint.type);
  }
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    if (world.rotors[i].robot != robot) continue;
    if (out.rotor_count == 0) out.first_rotor = static_cast<int>(i);
    ++out.rotor_count;
  }
  return out;
}

}  // namespace

int add_param(StateLayout& layout, const EnvParam& param) {
  layout.param_info.push_back(param);
  return static_cast<int>(layout.param_info.size()) - 1;
}

StateLayout physics_layout(const Topology& world) {
  StateLayout layout;
  layout.header.size = kHeaderSize;
  for (std::size_t r = 0; r < world.scenario.robots.size(); ++r) {
    layout.robots.push_back(make_robot_layout(world, static_cast<int>(r)));
    layout.q.size += layout.robots.back().q_count;
    layout.u.size += layout.robots.back().u_count;
  }
  layout.rotor_speed.size = layout.rotor_command.size = static_cast<int>(world.rotors.size());
  layout.coupling_forces.size = 3 * static_cast<int>(world.scenario.couplings.size());
  layout.bristles.size = 3 * count_bristles(world);
  add_physical_constants(layout, world);
  return layout;
}

int count_driven(const std::vector<DriveKind>& drives) {
  int count = 0;
  for (const DriveKind kind : drives) count += kind != DriveKind::kNone;
  return count;
}

int held_size(const WorldPlan& plan, int input) {
  const HeldInputRow& row = kHeldInputs[static_cast<std::size_t>(input)];
  if (row.is_of_rotors) return row.size * plan.layout.rotor_speed.size;
  int bodies = 0;
  for (const RobotLayout& robot : plan.layout.robots) bodies += robot.body_count;
  return row.size * bodies;
}

StateLayout finish_layout(const WorldPlan& plan) {
  StateLayout layout = plan.layout;
  layout.wrench.size = 6 * static_cast<int>(plan.sites.size());
  layout.drive.size = kDriveSize * count_driven(plan.drives);
  layout.joint_command.size = layout.joint_state.size = static_cast<int>(plan.joint_drives.size());
  for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
    const auto input = static_cast<std::size_t>(i);
    layout.held[input].size = plan.holds[input] ? held_size(plan, i) : 0;
  }
  layout.params.size = static_cast<int>(layout.param_info.size());
  layout.words = 0;
  const auto place = [&](Block& block) {
    block.offset = layout.words;
    layout.words += block.size;
  };
  for (Block* block : {&layout.header, &layout.q, &layout.u, &layout.rotor_speed,
                       &layout.rotor_command, &layout.wrench, &layout.drive, &layout.joint_command,
                       &layout.joint_state, &layout.coupling_forces, &layout.bristles}) {
    place(*block);
  }
  for (Block& block : layout.held) place(block);
  for (Block* block : {&layout.bodies_before, &layout.params, &layout.action, &layout.command,
                       &layout.sensors, &layout.contacts, &layout.contact_pairs,
                       &layout.joint_reactions, &layout.plugin_state, &layout.last_observation}) {
    place(*block);
  }
  return layout;
}

}  // namespace skybody
