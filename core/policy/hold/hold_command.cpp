// Converts setpoints of the hold baseline to the command of each control mode.
#include <algorithm>
#include <cmath>

#include "core/base/math/math.h"
#include "core/physics/forces/rotor_allocation.h"
#include "core/policy/hold/hold_setpoint.h"

namespace skybody {
namespace {

using V = Vec3<double>;

void put(const V& v, std::vector<double>& values, std::size_t at) {
  std::copy(&v.x, &v.x + 3, values.begin() + static_cast<std::ptrdiff_t>(at));
}

}  // namespace

/// Nominal weight of the robot with all bodies on its joints [N].
double HoldPolicy::nominal_weight(const Robot& robot) const {
  const std::vector<double>& params = compiled_.world().layout.nominal_params();
  double mass = 0.0;
  for (int b = robot.base; b < robot.base + robot.body_count; ++b) {
    const int first = compiled_.layout().body_params[static_cast<std::size_t>(b)];
    mass += params[static_cast<std::size_t>(first + kMass)];
  }
  return mass * norm(gravity_of(params));
}

/// The setpoint as the command of the robot's first controller.
std::vector<double> HoldPolicy::command(const Robot& robot, const View& view,
                                        const Setpoint& setpoint) const {
  const V& p = setpoint.position;
  const V way = shortened(p - view.base.position, kMaxError);
  const Quat<double> level = attitude_along({0.0, 0.0, 1.0}, setpoint.yaw);
  switch (robot.signal) {
    case SKYBODY_CTBR:
      return {setpoint.thrust, setpoint.rates.x, setpoint.rates.y, setpoint.rates.z};
    case SKYBODY_CTBT:
      return {setpoint.thrust, setpoint.torque.x, setpoint.torque.y, setpoint.torque.z};
    case SKYBODY_SRT:
      return rotor_thrusts(robot, view, setpoint);
    case SKYBODY_ROTOR_SPEED:
    case SKYBODY_THROTTLE:
      return rotor_speeds(robot, view, setpoint);
    case SKYBODY_WRENCH:
      return wrench(robot, view, setpoint);
    case SKYBODY_VELOCITY: {
      const V v = rotate_inverse(view.base.rotation, kPositionBandwidth * way + setpoint.velocity);
      const V r = rates_towards(level, view.base.rotation, BandwidthScale());
      return {v.x, v.y, v.z, r.x, r.y, r.z};
    }
    case SKYBODY_POSE:
      return {p.x, p.y, p.z, level.w, level.x, level.y, level.z};
    case SKYBODY_ATTITUDE: {
      const Quat<double>& q = setpoint.attitude;
      std::vector<double> values{setpoint.thrust, q.w, q.x, q.y, q.z};
      values.resize(robot.low.size());  // rates of 0 if the command has rates
      return values;
    }
    case SKYBODY_FORCE: {
      // A range that extends below 0 is for a force in addition to the nominal weight.
      const double carried = robot.low[2] < 0.0 ? nominal_weight(robot) : 0.0;
      std::vector<double> values{setpoint.force.x, setpoint.force.y, setpoint.force.z - carried,
                                 setpoint.yaw};
      values.resize(robot.low.size());
      return values;
    }
    case SKYBODY_ACCELERATION: {
      const V a = setpoint.force / view.mass + view.gravity;
      return {a.x, a.y, a.z, setpoint.yaw};
    }
    case SKYBODY_VELOCITY_TRACKING: {
      const V v = view.scale.all * kPositionBandwidth * way + setpoint.velocity;
      const V r = rates_towards(level, view.base.rotation, view.scale);
      return {v.x, v.y, v.z, r.z};
    }
    case SKYBODY_JOINT:
      return joint_commands(robot, view, setpoint);
    case SKYBODY_NONE:
      return {};
    case SKYBODY_POSITION:
      return {p.x, p.y, p.z, setpoint.yaw};
    default:  // SKYBODY_TRAJECTORY
      return trajectory(robot, setpoint);
  }
}

/// The goal's motion: all later points have its present acceleration. Rates of the yaw, jerk and
/// snap are unknown: 0.
std::vector<double> HoldPolicy::trajectory(const Robot& robot, const Setpoint& setpoint) const {
  std::vector<double> values(robot.low.size());
  double ahead = 0.0;  // [s]
  for (std::size_t k = 0; k + SKYBODY_REFERENCE_VALUES <= values.size();
       k += SKYBODY_REFERENCE_VALUES) {
    const V velocity = setpoint.velocity + ahead * setpoint.acceleration;
    put(setpoint.position + (0.5 * ahead) * (setpoint.velocity + velocity), values, k);
    put(velocity, values, k + 3);
    put(setpoint.acceleration, values, k + 6);
    values[k + 15] = setpoint.yaw;
    ahead += robot.spacing;
  }
  return values;
}

/// Positions that reach the goal for the arm's joints, the scenario's positions for others.
std::vector<double> HoldPolicy::joint_commands(const Robot& robot, const View& view,
                                               const Setpoint& setpoint) const {
  std::vector<double> commands = robot.joints;
  for (std::size_t k = 0; k < std::min(commands.size(), robot.drives.size()); ++k) {
    const int joint = robot.arm.joint_of(robot.drives[k]);
    if (joint < 0) continue;
    const auto place = static_cast<std::size_t>(joint);
    commands[k] = robot.arm.command(view, place, setpoint.reach[place]);
  }
  return commands;
}

/// Single thrusts [N] that give the desired collective thrust and torque. Only reversible rotors
/// may have negative thrust. Rotors have little torque about z: it is scaled down until all rotors
/// are within their limits, since saturation would cost lift.
std::vector<double> HoldPolicy::rotor_thrusts(const Robot& robot, const View& view,
                                              const Setpoint& setpoint) const {
  const std::vector<double> allocation = allocation_of(compiled_.world(), robot.index, view.params);
  std::vector<double> thrusts(robot.low.size());  // 0 if a draw leaves no allocation
  std::vector<double> turning(thrusts.size());
  double share = 1.0;
  const std::vector<Rotor>& rotors =
      compiled_.world().scenario.robots[static_cast<std::size_t>(robot.index)].model.rotors;
  const auto least = [&](std::size_t i) {
    const double speed = min(0.0, rotors[i].min_speed);
    return -(rotor_params(robot, view, i)[kThrustConstant] * speed * speed);
  };
  for (std::size_t i = 0; i < allocation.size() / 4; ++i) {
    const double* row = allocation.data() + 4 * i;
    const double* rotor = rotor_params(robot, view, i);
    const double full = rotor[kThrustConstant] * rotor[kMaxSpeed] * rotor[kMaxSpeed];
    thrusts[i] = row[0] * setpoint.thrust + row[1] * setpoint.torque.x + row[2] * setpoint.torque.y;
    turning[i] = row[3] * setpoint.torque.z;
    const double room = turning[i] > 0.0 ? full - thrusts[i] : thrusts[i] - least(i);
    if (std::abs(turning[i]) > room)
      share = std::min(share, std::max(0.0, room) / std::abs(turning[i]));
  }
  for (std::size_t i = 0; i < thrusts.size(); ++i) {
    thrusts[i] = std::max(least(i), thrusts[i] + share * turning[i]);
  }
  return thrusts;
}

/// The same as speeds [rad/s], or as fractions of the rotors' maximum speeds.
std::vector<double> HoldPolicy::rotor_speeds(const Robot& robot, const View& view,
                                             const Setpoint& setpoint) const {
  std::vector<double> speeds = rotor_thrusts(robot, view, setpoint);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const double* rotor = rotor_params(robot, view, i);
    speeds[i] = copysign(sqrt(abs(speeds[i]) / rotor[kThrustConstant]), speeds[i]);
    if (robot.signal == SKYBODY_THROTTLE) speeds[i] /= rotor[kMaxSpeed];
  }
  return speeds;
}

/// The drawn constants of one of its rotors.
const double* HoldPolicy::rotor_params(const Robot& robot, const View& view, std::size_t i) const {
  const StateLayout& layout = compiled_.layout();
  const int first = layout.robots[static_cast<std::size_t>(robot.index)].first_rotor;
  return view.params.data() + layout.rotor_params[static_cast<std::size_t>(first) + i];
}

/// The first site carries the whole robot, level; the others stay idle.
std::vector<double> HoldPolicy::wrench(const Robot& robot, const View& view,
                                       const Setpoint& setpoint) const {
  const Quat<double>& q = view.base.rotation;
  const V rates = rates_towards(attitude_along({0.0, 0.0, 1.0}, setpoint.yaw), q, BandwidthScale());
  const V moment =
      rotate(q, torque_for(rates, view.base.angular_velocity, view.inertia, BandwidthScale()));
  std::vector<double> values(robot.low.size(), 0.0);
  const double first[6] = {setpoint.force.x, setpoint.force.y, setpoint.force.z,
                           moment.x,         moment.y,         moment.z};
  std::copy(first, first + 6, values.begin());
  return values;
}

}  // namespace skybody
