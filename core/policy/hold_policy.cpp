#include "core/policy/hold_policy.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/base/math.h"
#include "core/env/setup_tables.h"
#include "core/physics/coupling/coupling_scene.h"
#include "core/policy/attitude_loops.h"
#include "core/policy/pseudo_inverse.h"

namespace skybody {
namespace {

// Bandwidths [rad/s]: each loop about four times slower than the one inside it
// (attitude_loops.cpp).
constexpr double kPositionBandwidth = 2.0;
constexpr double kSwingPole = 1.8;    // of what hangs
constexpr double kCarryPole = 1.2;    // of what stands: two bring it to its place,
constexpr double kBalancePole = 3.3;  // two are about as quick as it would fall
constexpr double kMaxCarried = 3.0;   // [m] what stands is carried at 1.3 m/s at most
constexpr double kLeastCable = 0.05;  // [m]
constexpr double kMaxError = 1.5;     // [m] limits the speed of long flights to 1.5 m/s
constexpr double kMaxLateral = 5.0;   // [m/s^2], 27 degrees
constexpr double kMaxVertical = 2.0;  // [m/s^2], below what a thrust-to-weight of 1.27 allows

using V = Vec3<double>;

V limited(const V& v, double most) {
  const double n = norm(v);
  return n > most ? v * (most / n) : v;
}

const PluginInstance& last_of(const CompiledScenario& compiled, const ControllerChain& chain) {
  const auto& controllers = compiled.plugins(SKYBODY_CONTROLLER);
  return controllers[static_cast<std::size_t>(chain.first + chain.count - 1)];
}

/// All drives of one robot's joints that its actions command.
std::vector<JointDrive> drives_of(const CompiledScenario& compiled, int robot) {
  std::vector<JointDrive> drives;
  for (const ControllerChain& chain : compiled.chains()) {
    if (chain.robot != robot || chain.signal != SKYBODY_JOINT || chain.is_fed) continue;
    const std::vector<JointDrive>& own = last_of(compiled, chain).joints;
    drives.insert(drives.end(), own.begin(), own.end());
  }
  return drives;
}

/// What keeps joints as the scenario has them at a reset: position drives at their positions,
/// others at rest.
std::vector<double> joints_at_reset(const World& world, const CompiledScenario& compiled,
                                    const ControllerChain& chain) {
  const std::vector<JointDrive>& drives = last_of(compiled, chain).joints;
  std::vector<double> commands(static_cast<std::size_t>(chain.inputs), 0.0);
  for (std::size_t k = 0; k < std::min(commands.size(), drives.size()); ++k) {
    const JointDrive& drive = drives[k];
    const WorldBody& body = world.bodies[static_cast<std::size_t>(drive.body)];
    if (drive.mode == JointMode::kPosition) commands[k] = body.model->joint.position;
  }
  return commands;
}

}  // namespace

/// What the loops want, before it is put in the mode's words.
struct HoldPolicy::Wish {
  V position;           // of the goal, W [m]
  V velocity;           // of the goal, W [m/s]
  V acceleration;       // of the goal, W [m/s^2]
  double yaw = 0.0;     // of the goal [rad]
  V force;              // on the whole robot, W [N]
  double thrust = 0.0;  // collective, along the body's z [N]
  Quat<double> attitude{1.0, 0.0, 0.0, 0.0};
  V rates;                    // B [rad/s]
  V torque;                   // B [N m]
  std::vector<double> reach;  // positions of the arm's joints [rad] or [m]
};

/// One robot's present state and true constants.
struct HoldPolicy::View : KnownState {
  const std::vector<double>& goals;
  const std::vector<double>& motions;  // of the goals
  const BodyState& base;
  double mass;              // of the whole robot [kg]
  double base_mass;         // [kg]
  SymMat3<double> inertia;  // of the base [kg m^2]
  BandwidthScale scale;
};

HoldPolicy::HoldPolicy(const CompiledScenario& compiled) : compiled_(compiled) {
  const World& world = compiled.world();
  if (!compiled.task().actions.empty()) {
    throw Error("the hold baseline cannot fly task `" + compiled.task().plugin +
                "`, which has actions of its own; use --policy zero or random");
  }
  for (const ControllerChain& chain : compiled.chains()) {
    if (chain.is_fed) continue;
    const int r = chain.robot;
    const PluginInstance& first =
        compiled.plugins(SKYBODY_CONTROLLER)[static_cast<std::size_t>(chain.first)];
    if (chain.team >= 0) {
      throw Error("the hold baseline cannot fly team `" +
                  world.scenario.teams[static_cast<std::size_t>(chain.team)].name +
                  "`: it knows commands of single robots; use --policy zero or random");
    }
    Robot robot;
    robot.index = r;
    robot.base = compiled.layout().robots[static_cast<std::size_t>(r)].first_body;
    robot.body_count = compiled.layout().robots[static_cast<std::size_t>(r)].body_count;
    robot.goal_body = robot.base;
    robot.signal = first.input_signal;
    robot.action = chain.command;
    robot.low = first.low;
    if (robot.signal == SKYBODY_JOINT) {
      robot.joints = joints_at_reset(world, compiled, chain);
      robot.drives = last_of(compiled, chain).joints;
    }
    robot.high = first.high;
    const auto& goals = compiled.task().goals;
    for (std::size_t g = 0; g < goals.size(); ++g) {
      if (goals[g].robot != r) continue;
      robot.goal = static_cast<int>(g);
      robot.goal_body = goals[g].body;
    }
    if (robot.goal >= 0) {
      robot.tool = goals[static_cast<std::size_t>(robot.goal)].point;
      robot.arm = Arm(world, robot.base, robot.goal_body, robot.tool, drives_of(compiled, r));
    }
    robot.swings = robot.goal_body != robot.base && !robot.arm.can_reach();
    robot.cable = hanging_length(world, robot.base, robot.goal_body, robot.tool);
    const bool needs_rotors = robot.signal == SKYBODY_ROTOR_SPEED || robot.signal == SKYBODY_SRT ||
                              robot.signal == SKYBODY_THROTTLE;
    if (robot.swings && std::abs(robot.cable) < kLeastCable) {
      throw Error(
          "the hold baseline cannot carry `" +
          world.bodies[static_cast<std::size_t>(robot.goal_body)].model->name +
          "`: it neither hangs below the base nor stands above; use --policy zero or random");
    }
    if (needs_rotors && allocation_of(world, r, world.layout.nominal_params()).empty()) {
      throw Error(
          "the hold baseline cannot fly robot `" +
          world.scenario.robots[static_cast<std::size_t>(r)].name +
          "`: its rotors do not give thrust and all three torques; use --policy zero or random");
    }
    robots_.push_back(std::move(robot));
  }
  share_loads();
}

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
  const std::vector<BodyState>& bodies = simulation.bodies();
  const std::vector<int>& first = compiled_.layout().body_params;
  for (const Robot& robot : robots_) {
    const double* base = params.data() + first[static_cast<std::size_t>(robot.base)];
    View view{{compiled_.world(), bodies, params, gravity_of(params)},
              goals,
              motions,
              bodies[static_cast<std::size_t>(robot.base)],
              0.0,
              base[kMass],
              mass_properties(base).inertia,
              {}};
    for (int b = robot.base; b < robot.base + robot.body_count; ++b) {
      view.mass += params[static_cast<std::size_t>(first[static_cast<std::size_t>(b)] + kMass)];
    }
    for (const int b : robot.loads) {
      view.mass += robot.load_share *
                   params[static_cast<std::size_t>(first[static_cast<std::size_t>(b)] + kMass)];
    }
    view.scale = bandwidth_scale(compiled_.layout(),
                                 compiled_.layout().robots[static_cast<std::size_t>(robot.index)],
                                 params, view.mass * norm(view.gravity));
    const std::vector<double> wanted = command(robot, view, wish(robot, view));
    for (std::size_t k = 0; k < robot.low.size(); ++k) {
      const double range = robot.high[k] - robot.low[k];
      const double a = range > 0.0 ? 2.0 * (wanted[k] - robot.low[k]) / range - 1.0 : 0.0;
      action[static_cast<std::size_t>(robot.action) + k] =
          static_cast<float>(std::clamp(a, -1.0, 1.0));
    }
  }
}

/// As it is drawn [m/s^2], W.
Vec3<double> HoldPolicy::gravity_of(const std::vector<double>& params) const {
  const double* g = params.data() + compiled_.layout().world_params + kGravity;
  return {g[0], g[1], g[2]};
}

/// Of the robot with all that joints hold on it, as the scenario has it [N].
double HoldPolicy::nominal_weight(const Robot& robot) const {
  const std::vector<double>& params = compiled_.world().layout.nominal_params();
  double mass = 0.0;
  for (int b = robot.base; b < robot.base + robot.body_count; ++b) {
    const int first = compiled_.layout().body_params[static_cast<std::size_t>(b)];
    mass += params[static_cast<std::size_t>(first + kMass)];
  }
  return mass * norm(gravity_of(params));
}

/// Goal -> force -> attitude -> rates -> torque.
HoldPolicy::Wish HoldPolicy::wish(const Robot& robot, const View& view) const {
  const World& world = compiled_.world();
  const RobotUse& use = world.scenario.robots[static_cast<std::size_t>(robot.index)];
  Wish wish;
  wish.position = use.pose.position;
  wish.yaw = yaw(use.pose.rotation);
  if (robot.goal >= 0) {
    const double* g = view.goals.data() + 4 * robot.goal;
    wish.position = {g[0], g[1], g[2]};
    wish.yaw = g[3];
    const double* m = view.motions.data() + 6 * robot.goal;
    wish.velocity = {m[0], m[1], m[2]};
    wish.acceleration = {m[3], m[4], m[5]};
    if (robot.arm.can_reach()) share_reach(robot, view, wish);
  }
  // Thrust carries weight, the wanted acceleration, and what disturbs.
  const double* disturbance =
      view.params.data() + compiled_.layout().robot_params[static_cast<std::size_t>(robot.index)];
  wish.force = view.mass * (acceleration(robot, view, wish) - view.gravity) -
               V{disturbance[0], disturbance[1], disturbance[2]};
  wish.attitude = attitude_along(wish.force, wish.yaw);
  wish.thrust = std::max(0.0, dot(wish.force, body_z(view.base.rotation)));
  wish.rates = rates_towards(wish.attitude, view.base.rotation, view.scale);
  wish.torque = torque_for(wish.rates, view.base.angular_velocity, view.inertia, view.scale) -
                V{disturbance[3], disturbance[4], disturbance[5]};
  if (robot.arm.can_reach()) wish.torque += torque_of_arm(robot, view, wish.thrust);
  return wish;
}

/// The vehicle keeps the scenario's place, the arm reaches from there, and what it lacks is flown.
void HoldPolicy::share_reach(const Robot& robot, const View& view, Wish& wish) const {
  const BodyState& carrier = view.bodies[static_cast<std::size_t>(robot.goal_body)];
  const V tool = wish.position + rotate(carrier.rotation, robot.tool);
  const V home =
      compiled_.world().scenario.robots[static_cast<std::size_t>(robot.index)].pose.position;
  const Quat<double> heading = attitude_along({0.0, 0.0, 1.0}, wish.yaw);
  wish.reach = robot.arm.reach(rotate_inverse(heading, tool - home));
  wish.position = tool - rotate(heading, robot.arm.place(wish.reach));
}

/// What the rotors have to add, as they push through the base and all that it carries hangs on the
/// common centre of mass; B [N m].
Vec3<double> HoldPolicy::torque_of_arm(const Robot& robot, const View& view, double thrust) const {
  const V lever =
      center_of_mass(view, robot.base, robot.body_count) - center_of_mass(view, robot.base, 1);
  return cross(rotate_inverse(view.base.rotation, lever), V{0.0, 0.0, thrust});
}

/// Wanted acceleration of the base, W, without gravity [m/s^2], within what every vehicle can do.
Vec3<double> HoldPolicy::acceleration(const Robot& robot, const View& view,
                                      const Wish& wish) const {
  const double omega = view.scale.all * kPositionBandwidth;
  const BodyState& base = view.base;
  V a;
  if (robot.swings) {
    a = swing(robot, view, wish);
  } else {
    const V error = limited(wish.position - base.position, kMaxError);
    a = (omega * omega) * error + (2.0 * omega) * (wish.velocity - base.velocity) +
        wish.acceleration;
  }
  const V lateral = limited({a.x, a.y, 0.0}, kMaxLateral);
  return {lateral.x, lateral.y, std::clamp(a.z, -kMaxVertical, kMaxVertical)};
}

/// The same for a goal about what swings below the base or stands above: a pendulum on an
/// accelerated pivot, x_L'' = w2 (x - x_L), w2 < 0 where it stands, with poles at -p and -q, two
/// each, on the error of the tool's place.
Vec3<double> HoldPolicy::swing(const Robot& robot, const View& view, const Wish& wish) const {
  const BodyState& base = view.base;
  const BodyState& bob = view.bodies[static_cast<std::size_t>(robot.goal_body)];
  const bool stands = robot.cable < 0.0;
  const V arm = rotate(bob.rotation, robot.tool);
  const V place = bob.position + arm;
  const V speed = bob.velocity + rotate(bob.rotation, cross(bob.angular_velocity, robot.tool));
  const double w2 = norm(view.gravity) / robot.cable;
  const double p = view.scale.all * (stands ? kCarryPole : kSwingPole);
  const double q = stands ? kBalancePole : p;
  const V offset = base.position - place, slip = base.velocity - speed;
  const V error = place - (wish.position + arm);
  const V far = stands ? limited({error.x, error.y, 0.0}, kMaxCarried) : error;
  V a = (w2 - (p * p + q * q + 4.0 * p * q)) * offset - 2.0 * (p + q) * slip -
        (2.0 * p * q * (p + q) * speed + p * p * q * q * far) / w2;
  // What swings pulls the base sideways, what stands pushes it: part of the thrust's lateral share
  // answers that.
  const double carried = (view.mass - view.base_mass) / view.mass;
  a = (1.0 - carried) * a + (carried * w2) * offset;
  const double omega = view.scale.all * kPositionBandwidth;
  a.z = -omega * omega * error.z - 2.0 * omega * base.velocity.z;
  return a;
}

/// The wish in the words of the robot's first controller.
std::vector<double> HoldPolicy::command(const Robot& robot, const View& view,
                                        const Wish& wish) const {
  const V& p = wish.position;
  switch (robot.signal) {
    case SKYBODY_CTBR:
      return {wish.thrust, wish.rates.x, wish.rates.y, wish.rates.z};
    case SKYBODY_CTBT:
      return {wish.thrust, wish.torque.x, wish.torque.y, wish.torque.z};
    case SKYBODY_SRT:
      return rotor_thrusts(robot, view, wish);
    case SKYBODY_ROTOR_SPEED:
    case SKYBODY_THROTTLE:
      return rotor_speeds(robot, view, wish);
    case SKYBODY_WRENCH:
      return wrench(robot, view, wish);
    case SKYBODY_VELOCITY: {
      const V v = rotate_inverse(
          view.base.rotation,
          kPositionBandwidth * limited(p - view.base.position, kMaxError) + wish.velocity);
      const V r = rates_towards(attitude_along({0.0, 0.0, 1.0}, wish.yaw), view.base.rotation,
                                BandwidthScale());
      return {v.x, v.y, v.z, r.x, r.y, r.z};
    }
    case SKYBODY_POSE: {
      const Quat<double> q = attitude_along({0.0, 0.0, 1.0}, wish.yaw);
      return {p.x, p.y, p.z, q.w, q.x, q.y, q.z};
    }
    case SKYBODY_ATTITUDE: {
      const Quat<double>& q = wish.attitude;
      std::vector<double> values{wish.thrust, q.w, q.x, q.y, q.z};
      values.resize(robot.low.size());  // rates of 0, where it takes them
      return values;
    }
    case SKYBODY_FORCE: {
      // A range that goes below 0 is that of a force on top of the nominal weight.
      const double carried = robot.low[2] < 0.0 ? nominal_weight(robot) : 0.0;
      std::vector<double> values{wish.force.x, wish.force.y, wish.force.z - carried, wish.yaw};
      values.resize(robot.low.size());
      return values;
    }
    case SKYBODY_ACCELERATION: {
      const V a = wish.force / view.mass + view.gravity;
      return {a.x, a.y, a.z, wish.yaw};
    }
    case SKYBODY_VELOCITY_TRACKING: {
      const V v = view.scale.all * kPositionBandwidth * limited(p - view.base.position, kMaxError) +
                  wish.velocity;
      const V r =
          rates_towards(attitude_along({0.0, 0.0, 1.0}, wish.yaw), view.base.rotation, view.scale);
      return {v.x, v.y, v.z, r.z};
    }
    case SKYBODY_JOINT:
      return joint_commands(robot, view, wish);
    case SKYBODY_NONE:
      return {};
    case SKYBODY_POSITION:
      return {p.x, p.y, p.z, wish.yaw};
    default: {  // SKYBODY_TRAJECTORY: points that rest
      std::vector<double> values(robot.low.size());
      for (std::size_t k = 0; k + SKYBODY_REFERENCE_VALUES <= values.size();
           k += SKYBODY_REFERENCE_VALUES) {
        std::copy(&p.x, &p.x + 3, values.begin() + static_cast<std::ptrdiff_t>(k));
        values[k + 15] = wish.yaw;
      }
      return values;
    }
  }
}

/// Of the arm's joints what reaches, of others what the scenario has.
std::vector<double> HoldPolicy::joint_commands(const Robot& robot, const View& view,
                                               const Wish& wish) const {
  std::vector<double> commands = robot.joints;
  for (std::size_t k = 0; k < std::min(commands.size(), robot.drives.size()); ++k) {
    const int joint = robot.arm.joint_of(robot.drives[k]);
    if (joint < 0) continue;
    const auto place = static_cast<std::size_t>(joint);
    commands[k] = robot.arm.command(view, place, wish.reach[place]);
  }
  return commands;
}

/// Single thrusts [N] that give the wished collective thrust and torque, none pulling. Of the
/// torque about z, for which rotors have little to give, what leaves them within their limits:
/// beyond them it would cost lift.
std::vector<double> HoldPolicy::rotor_thrusts(const Robot& robot, const View& view,
                                              const Wish& wish) const {
  const std::vector<double> allocation = allocation_of(compiled_.world(), robot.index, view.params);
  std::vector<double> thrusts(robot.low.size());  // 0 where a draw leaves no allocation
  std::vector<double> turning(thrusts.size());
  double share = 1.0;
  for (std::size_t i = 0; i < allocation.size() / 4; ++i) {
    const double* row = allocation.data() + 4 * i;
    const double* rotor = rotor_params(robot, view, i);
    const double full = rotor[kThrustConstant] * rotor[kMaxSpeed] * rotor[kMaxSpeed];
    thrusts[i] = row[0] * wish.thrust + row[1] * wish.torque.x + row[2] * wish.torque.y;
    turning[i] = row[3] * wish.torque.z;
    const double room = turning[i] > 0.0 ? full - thrusts[i] : thrusts[i];
    if (std::abs(turning[i]) > room)
      share = std::min(share, std::max(0.0, room) / std::abs(turning[i]));
  }
  for (std::size_t i = 0; i < thrusts.size(); ++i) {
    thrusts[i] = std::max(0.0, thrusts[i] + share * turning[i]);
  }
  return thrusts;
}

/// The same as speeds [rad/s], or as shares of the rotors' largest ones.
std::vector<double> HoldPolicy::rotor_speeds(const Robot& robot, const View& view,
                                             const Wish& wish) const {
  std::vector<double> speeds = rotor_thrusts(robot, view, wish);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const double* rotor = rotor_params(robot, view, i);
    speeds[i] = sqrt(speeds[i] / rotor[kThrustConstant]);
    if (robot.signal == SKYBODY_THROTTLE) speeds[i] /= rotor[kMaxSpeed];
  }
  return speeds;
}

/// The drawn constants of one of its rotors.
const double* HoldPolicy::rotor_params(const Robot& robot, const View& view, std::size_t i) const {
  const Layout& layout = compiled_.layout();
  const int first = layout.robots[static_cast<std::size_t>(robot.index)].first_rotor;
  return view.params.data() + layout.rotor_params[static_cast<std::size_t>(first) + i];
}

/// The whole robot hangs, level, on the first site; the others stay idle.
std::vector<double> HoldPolicy::wrench(const Robot& robot, const View& view,
                                       const Wish& wish) const {
  const Quat<double>& q = view.base.rotation;
  const V rates = rates_towards(attitude_along({0.0, 0.0, 1.0}, wish.yaw), q, BandwidthScale());
  const V moment =
      rotate(q, torque_for(rates, view.base.angular_velocity, view.inertia, BandwidthScale()));
  std::vector<double> values(robot.low.size(), 0.0);
  const double first[6] = {wish.force.x, wish.force.y, wish.force.z, moment.x, moment.y, moment.z};
  std::copy(first, first + 6, values.begin());
  return values;
}

}  // namespace skybody
