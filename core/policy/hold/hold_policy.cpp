// The hold baseline by robots: setup at the start, and actions at every step. The loops are in
// hold_setpoint.cpp, the commands of each control mode in hold_command.cpp.
#include "core/policy/hold/hold_policy.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/assemble/trajectory_chain.h"
#include "core/base/system/error.h"
#include "core/env/plugin_setup_tables.h"
#include "core/physics/coupling/coupling_scene.h"
#include "core/physics/forces/rotor_allocation.h"
#include "core/policy/hold/hold_setpoint.h"

namespace skybody {
namespace {

constexpr double kLeastCable = 0.05;  // [m]

const PluginInstance& last_of(const CompiledScenario& compiled, const ControllerChain& chain) {
  const auto& controllers = compiled.plugins(SKYBODY_CONTROLLER);
  return controllers[static_cast<std::size_t>(chain.first + chain.count - 1)];
}

/// Depth of a point of `body` [m, its frame] below the origin of `base` with all joints at 0 [m];
/// less than 0 if it is above.
double hanging_length(const World& world, int base, int body, const Vec3<double>& point) {
  Vec3<double> position = point;
  for (int b = body; b != base && b >= 0; b = world.bodies[static_cast<std::size_t>(b)].parent) {
    const Joint& joint = world.bodies[static_cast<std::size_t>(b)].model->joint;
    const Quat<double> turn =
        joint.frame_in_parent.rotation * conjugate(joint.frame_in_body.rotation);
    position =
        joint.frame_in_parent.position + rotate(turn, position - joint.frame_in_body.position);
  }
  return -position.z;
}

/// All drives of one robot's joints that its actions command.
std::vector<JointDrive> drives_of(const CompiledScenario& compiled, int robot) {
  std::vector<JointDrive> drives;
  for (const ControllerChain& chain : compiled.chains()) {
    if (chain.robot != robot || chain.signal != SKYBODY_JOINT || chain.is_fed) continue;
    const std::vector<JointDrive>& own = last_of(compiled, chain).controller.joints;
    drives.insert(drives.end(), own.begin(), own.end());
  }
  return drives;
}

/// Commands that keep joints in the scenario's state at a reset: position drives at their
/// positions, others at rest.
std::vector<double> joints_at_reset(const World& world, const CompiledScenario& compiled,
                                    const ControllerChain& chain) {
  const std::vector<JointDrive>& drives = last_of(compiled, chain).controller.joints;
  std::vector<double> commands(static_cast<std::size_t>(chain.inputs), 0.0);
  for (std::size_t k = 0; k < std::min(commands.size(), drives.size()); ++k) {
    const JointDrive& drive = drives[k];
    const WorldBody& body = world.bodies[static_cast<std::size_t>(drive.body)];
    if (drive.mode == JointMode::kPosition) commands[k] = body.model->joint.position;
  }
  return commands;
}

}  // namespace

HoldPolicy::HoldPolicy(const CompiledScenario& compiled) : compiled_(compiled) {
  if (!compiled.task().task.actions.empty()) {
    throw Error("the hold baseline cannot fly task `" + compiled.task().plugin +
                "`, which has actions of its own; use --policy zero or random");
  }
  for (const ControllerChain& chain : compiled.chains()) {
    if (chain.is_fed) continue;
    if (chain.team >= 0) {
      const auto team = static_cast<std::size_t>(chain.team);
      throw Error("the hold baseline cannot fly team `" +
                  compiled.world().scenario.teams[team].name +
                  "`: it knows commands of single robots; use --policy zero or random");
    }
    Robot robot = commanded_robot(chain);
    take_goal(robot);
    check(robot);
    robots_.push_back(std::move(robot));
  }
  share_loads();
}

/// A robot with the properties of its commanded chain.
HoldPolicy::Robot HoldPolicy::commanded_robot(const ControllerChain& chain) const {
  const RobotLayout& layout = compiled_.layout().robots[static_cast<std::size_t>(chain.robot)];
  const PluginInstance& first =
      compiled_.plugins(SKYBODY_CONTROLLER)[static_cast<std::size_t>(chain.first)];
  Robot robot;
  robot.index = chain.robot;
  robot.base = layout.first_body;
  robot.body_count = layout.body_count;
  robot.signal = first.controller.input_signal;
  robot.action = chain.command;
  robot.low = first.controller.low;
  robot.high = first.controller.high;
  robot.spacing = point_spacing(first_controller(compiled_, chain));
  if (robot.signal == SKYBODY_JOINT) {
    robot.joints = joints_at_reset(compiled_.world(), compiled_, chain);
    robot.drives = last_of(compiled_, chain).controller.joints;
  }
  return robot;
}

/// Sets the robot's goal from the task, and the body point that is to reach it.
void HoldPolicy::take_goal(Robot& robot) const {
  const World& world = compiled_.world();
  robot.goal_body = robot.base;
  const auto& goals = compiled_.task().task.goals;
  for (std::size_t g = 0; g < goals.size(); ++g) {
    if (goals[g].robot != robot.index) continue;
    robot.goal = static_cast<int>(g);
    robot.goal_body = goals[g].body;
  }
  if (robot.goal >= 0) {
    robot.tool = goals[static_cast<std::size_t>(robot.goal)].point;
    robot.arm =
        Arm(world, robot.base, robot.goal_body, robot.tool, drives_of(compiled_, robot.index));
  }
  robot.swings = robot.goal_body != robot.base && !robot.arm.can_reach();
  robot.cable = hanging_length(world, robot.base, robot.goal_body, robot.tool);
}

/// @throws Error if the baseline cannot fly the robot
void HoldPolicy::check(const Robot& robot) const {
  const World& world = compiled_.world();
  if (robot.swings && std::abs(robot.cable) < kLeastCable) {
    throw Error("the hold baseline cannot carry `" +
                world.bodies[static_cast<std::size_t>(robot.goal_body)].model->name +
                "`: it neither hangs below the base nor stands above; use --policy zero or random");
  }
  const bool needs_rotors = robot.signal == SKYBODY_ROTOR_SPEED || robot.signal == SKYBODY_SRT ||
                            robot.signal == SKYBODY_THROTTLE;
  if (!needs_rotors) return;
  const std::string obstacle = allocation_obstacle(world, robot.index);
  if (obstacle.empty()) return;
  throw Error("the hold baseline cannot fly robot `" +
              world.scenario.robots[static_cast<std::size_t>(robot.index)].name + "`: " + obstacle +
              "; use --policy zero or random");
}

/// Robots without rotors that hang on robots with rotors are carried by these in equal shares.
void HoldPolicy::share_loads() {
  const World& world = compiled_.world();
  const std::vector<int> held_with = CouplingScene(world).held_with;
  const auto team_of = [&](int robot) { return held_with[static_cast<std::size_t>(robot)]; };
  for (Robot& robot : robots_) {
    const int team = team_of(robot.index);
    if (team < 0) continue;
    const auto has_rotors = [&](int index) {
      return world.layout.robots[static_cast<std::size_t>(index)].rotor_count > 0;
    };
    std::set<int> carriers;  // a robot may have several chains
    for (const Robot& other : robots_) {
      if (team_of(other.index) == team && has_rotors(other.index)) carriers.insert(other.index);
    }
    if (!has_rotors(robot.index)) continue;
    robot.load_share = 1.0 / static_cast<double>(carriers.size());
    for (std::size_t b = 0; b < world.bodies.size(); ++b) {
      const int owner = world.bodies[b].robot;
      const auto use = static_cast<std::size_t>(owner);
      const bool stands =
          world.scenario.robots[use].model.fixed_base || world.drives[use] != DriveKind::kNone;
      if (team_of(owner) != team || has_rotors(owner) || stands) continue;
      robot.loads.push_back(static_cast<int>(b));
    }
  }
}

void HoldPolicy::act(const Simulation& simulation, std::span<float> action) {
  const std::vector<double> params = simulation.params();
  const std::vector<double> goals = simulation.goals();
  const std::vector<double> motions = simulation.goal_motions();
  for (const Robot& robot : robots_) {
    const View view =
        view_of(robot, {compiled_.world(), simulation.bodies(), params, gravity_of(params)}, goals,
                motions);
    const std::vector<double> wanted = command(robot, view, setpoint(robot, view));
    for (std::size_t k = 0; k < robot.low.size(); ++k) {
      const double range = robot.high[k] - robot.low[k];
      const double a = range > 0.0 ? 2.0 * (wanted[k] - robot.low[k]) / range - 1.0 : 0.0;
      action[static_cast<std::size_t>(robot.action) + k] = clip_action(a);
    }
  }
}

/// Keeps references to its arguments.
HoldPolicy::View HoldPolicy::view_of(const Robot& robot, const KnownState& now,
                                     const std::vector<double>& goals,
                                     const std::vector<double>& motions) const {
  const std::vector<int>& first = compiled_.layout().body_params;
  const auto mass_of = [&](int body) {
    return now.params[static_cast<std::size_t>(first[static_cast<std::size_t>(body)] + kMass)];
  };
  const double* base = now.params.data() + first[static_cast<std::size_t>(robot.base)];
  View view{now,
            goals,
            motions,
            now.bodies[static_cast<std::size_t>(robot.base)],
            0.0,
            base[kMass],
            mass_properties(base).inertia,
            {}};
  for (int b = robot.base; b < robot.base + robot.body_count; ++b) view.mass += mass_of(b);
  for (const int b : robot.loads) view.mass += robot.load_share * mass_of(b);
  view.scale = bandwidth_scale(compiled_.layout(),
                               compiled_.layout().robots[static_cast<std::size_t>(robot.index)],
                               now.params, view.mass * norm(view.gravity));
  return view;
}

/// The drawn gravity [m/s^2], W.
Vec3<double> HoldPolicy::gravity_of(const std::vector<double>& params) const {
  const double* g = params.data() + compiled_.layout().world_params + kGravity;
  return {g[0], g[1], g[2]};
}

}  // namespace skybody
