#include "core/physics/world/world_layout.h"

#include <array>

#include "core/model/held_inputs.h"

namespace skybody {
namespace {

/// The least mass or moment of inertia that may be drawn: positive, and far below any vehicle's.
constexpr double kLeastPositive = 1e-12;

void add_body_params(Layout& layout, const Scenario& scenario, const WorldBody& body) {
  const std::string path =
      "robots." + scenario.robots[body.robot].name + ".links." + body.model->name;
  const MassProperties& mass = body.model->mass;
  const std::array<double, 3> com{mass.com.x, mass.com.y, mass.com.z};
  const SymMat3<double>& i = mass.inertia;
  const std::array<double, 6> inertia{i.xx, i.yy, i.zz, i.xy, i.xz, i.yz};
  layout.body_params.push_back(
      add_param(layout, {path + ".mass", "kg", mass.mass, kLeastPositive, kInfinity}));
  for (int k = 0; k < 3; ++k) {
    add_param(layout,
              {path + ".com[" + std::to_string(k) + "]", "m", com[k], -kInfinity, kInfinity});
  }
  for (int k = 0; k < 6; ++k) {
    const double least = k < 3 ? kLeastPositive : -kInfinity;
    add_param(layout, {path + ".inertia[" + std::to_string(k) + "]", "kg m^2", inertia[k], least,
                       kInfinity});
  }
}

void add_rotor_params(Layout& layout, const Scenario& scenario, const WorldRotor& rotor,
                      int index) {
  const std::string path =
      "robots." + scenario.robots[rotor.robot].name + ".rotors[" + std::to_string(index) + "].";
  const Rotor& m = *rotor.model;
  const auto add = [&](const char* name, const char* unit, double nominal, double least) {
    return add_param(layout, {path + name, unit, nominal, least, kInfinity});
  };
  // In the order of RotorParam.
  layout.rotor_params.push_back(add("thrust_constant", "N s^2/rad^2", m.thrust_constant, 0.0));
  add("moment_constant", "N m s^2/rad^2", m.moment_constant, 0.0);
  add("drag_constant", "N s^2/(m rad)", m.drag_constant, 0.0);
  add("rolling_moment_constant", "N m s^2/(m rad)", m.rolling_moment_constant, 0.0);
  add("inertia", "kg m^2", m.inertia, 0.0);
  add("max_speed", "rad/s", m.max_speed, kLeastPositive);
  add("tau_up", "s", m.tau_up, 0.0);
  add("tau_down", "s", m.tau_down, 0.0);
}

void add_disturbance_params(Layout& layout, const RobotUse& robot) {
  const std::string path = "robots." + robot.name + ".disturbance.";
  const auto add = [&](const std::string& name, const char* unit, const Vec3<double>& value) {
    const std::array<double, 3> values{value.x, value.y, value.z};
    for (int k = 0; k < 3; ++k) {
      add_param(layout, {path + name + "[" + std::to_string(k) + "]", unit, values[k], -kInfinity,
                         kInfinity});
    }
  };
  layout.disturbance_params.push_back(static_cast<int>(layout.param_info.size()));
  add("force", "N", robot.disturbance_force);
  add("moment", "N m", robot.disturbance_moment);
}

/// Where the coordinates of one robot lie.
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
    out.body_q.push_back(body.q);
    out.body_u.push_back(body.u);
  }
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    if (world.rotors[i].robot != robot) continue;
    if (out.rotor_count == 0) out.first_rotor = static_cast<int>(i);
    ++out.rotor_count;
  }
  return out;
}

}  // namespace

int add_param(Layout& layout, const EnvParam& param) {
  layout.param_info.push_back(param);
  return static_cast<int>(layout.param_info.size()) - 1;
}

Layout physics_layout(const Topology& world) {
  Layout layout;
  layout.header.size = kHeaderSize;
  for (std::size_t r = 0; r < world.scenario.robots.size(); ++r) {
    layout.robots.push_back(make_robot_layout(world, static_cast<int>(r)));
    layout.q.size += layout.robots.back().q_count;
    layout.u.size += layout.robots.back().u_count;
  }
  layout.rotor_speed.size = layout.rotor_command.size = static_cast<int>(world.rotors.size());

  const Scenario& scenario = world.scenario;
  for (const WorldBody& body : world.bodies) add_body_params(layout, scenario, body);
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    const int first = layout.robots[world.rotors[i].robot].first_rotor;
    add_rotor_params(layout, scenario, world.rotors[i], static_cast<int>(i) - first);
  }
  for (const RobotUse& robot : scenario.robots) add_disturbance_params(layout, robot);
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

Layout finish_layout(const WorldPlan& plan) {
  Layout layout = plan.layout;
  layout.wrench.size = 6 * static_cast<int>(plan.sites.size());
  layout.drive.size = 13 * count_driven(plan.drives);
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
  for (Block* block :
       {&layout.header, &layout.q, &layout.u, &layout.rotor_speed, &layout.rotor_command,
        &layout.wrench, &layout.drive, &layout.joint_command, &layout.joint_state}) {
    place(*block);
  }
  for (Block& block : layout.held) place(block);
  for (Block* block :
       {&layout.bodies_before, &layout.params, &layout.action, &layout.command, &layout.sensors,
        &layout.contacts, &layout.plugin_state, &layout.last_observation}) {
    place(*block);
  }
  return layout;
}

}  // namespace skybody
