// Loops of the hold baseline: goal -> force -> attitude -> rates -> torque.
#include "core/policy/hold/hold_setpoint.h"

#include <algorithm>

namespace skybody {
namespace {

constexpr double kSwingPole = 1.8;    // [rad/s], of a hanging load
constexpr double kCarryPole = 1.2;    // [rad/s], of a standing load: two poles move it to its place
constexpr double kBalancePole = 3.3;  // [rad/s], two poles, about as fast as it would fall
constexpr double kMaxCarried = 3.0;   // [m]: a standing load is carried at 1.3 m/s at most
constexpr double kMaxLateral = 5.0;   // [m/s^2], 27 degrees
constexpr double kMaxVertical = 2.0;  // [m/s^2], less than a thrust-to-weight of 1.27 allows

using V = Vec3<double>;

}  // namespace

/// Goal -> force -> attitude -> rates -> torque.
HoldPolicy::Setpoint HoldPolicy::setpoint(const Robot& robot, const View& view) const {
  const World& world = compiled_.world();
  const RobotUse& use = world.scenario.robots[static_cast<std::size_t>(robot.index)];
  Setpoint setpoint;
  setpoint.position = use.pose.position;
  setpoint.yaw = yaw(use.pose.rotation);
  if (robot.goal >= 0) {
    const double* g = view.goals.data() + 4 * robot.goal;
    setpoint.position = {g[0], g[1], g[2]};
    setpoint.yaw = g[3];
    const double* m = view.motions.data() + 6 * robot.goal;
    setpoint.velocity = {m[0], m[1], m[2]};
    setpoint.acceleration = {m[3], m[4], m[5]};
    if (robot.arm.can_reach()) share_reach(robot, view, setpoint);
  }
  // Thrust compensates weight and disturbances and adds the desired acceleration.
  const double* disturbance =
      view.params.data() + compiled_.layout().robot_params[static_cast<std::size_t>(robot.index)];
  setpoint.force = view.mass * (acceleration(robot, view, setpoint) - view.gravity) -
                   V{disturbance[0], disturbance[1], disturbance[2]};
  setpoint.attitude = attitude_along(setpoint.force, setpoint.yaw);
  setpoint.thrust = std::max(0.0, dot(setpoint.force, body_z(view.base.rotation)));
  setpoint.rates = rates_towards(setpoint.attitude, view.base.rotation, view.scale);
  setpoint.torque =
      torque_for(setpoint.rates, view.base.angular_velocity, view.inertia, view.scale) -
      V{disturbance[3], disturbance[4], disturbance[5]};
  if (robot.arm.can_reach()) setpoint.torque += torque_of_arm(robot, view, setpoint.thrust);
  return setpoint;
}

/// The vehicle stays at the scenario's place and the arm reaches from there; the vehicle flies the
/// remaining distance.
void HoldPolicy::share_reach(const Robot& robot, const View& view, Setpoint& setpoint) const {
  const BodyState& carrier = view.bodies[static_cast<std::size_t>(robot.goal_body)];
  const V tool = setpoint.position + rotate(carrier.rotation, robot.tool);
  const V home =
      compiled_.world().scenario.robots[static_cast<std::size_t>(robot.index)].pose.position;
  const Quat<double> heading = attitude_along({0.0, 0.0, 1.0}, setpoint.yaw);
  setpoint.reach = robot.arm.reach(rotate_inverse(heading, tool - home));
  setpoint.position = tool - rotate(heading, robot.arm.place(setpoint.reach));
}

/// Additional torque of the rotors, B [N m]: they push through the base, but the whole robot's
/// weight acts at the common centre of mass.
Vec3<double> HoldPolicy::torque_of_arm(const Robot& robot, const View& view, double thrust) const {
  const V lever =
      center_of_mass(view, robot.base, robot.body_count) - center_of_mass(view, robot.base, 1);
  return cross(rotate_inverse(view.base.rotation, lever), V{0.0, 0.0, thrust});
}

/// Desired acceleration of the base, W, without gravity [m/s^2], within the limits of every
/// vehicle.
Vec3<double> HoldPolicy::acceleration(const Robot& robot, const View& view,
                                      const Setpoint& setpoint) const {
  const double omega = view.scale.all * kPositionBandwidth;
  const BodyState& base = view.base;
  V a;
  if (robot.swings) {
    a = swing(robot, view, setpoint);
  } else {
    const V error = shortened(setpoint.position - base.position, kMaxError);
    a = (omega * omega) * error + (2.0 * omega) * (setpoint.velocity - base.velocity) +
        setpoint.acceleration;
  }
  const V lateral = shortened({a.x, a.y, 0.0}, kMaxLateral);
  return {lateral.x, lateral.y, std::clamp(a.z, -kMaxVertical, kMaxVertical)};
}

/// The same for a goal of a body that swings below the base or stands above it: a pendulum on an
/// accelerated pivot, x_L'' = w2 (x - x_L), w2 < 0 if it stands, with poles at -p and -q, two each,
/// on the error of the tool's position.
Vec3<double> HoldPolicy::swing(const Robot& robot, const View& view,
                               const Setpoint& setpoint) const {
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
  const V error = place - (setpoint.position + arm);
  const V far = stands ? shortened(V{error.x, error.y, 0.0}, kMaxCarried) : error;
  V a = (w2 - (p * p + q * q + 4.0 * p * q)) * offset - 2.0 * (p + q) * slip -
        (2.0 * p * q * (p + q) * speed + p * p * q * q * far) / w2;
  // A hanging load pulls the base sideways, a standing one pushes it: a part of the thrust's
  // lateral component compensates this.
  const double carried = (view.mass - view.base_mass) / view.mass;
  a = (1.0 - carried) * a + (carried * w2) * offset;
  const double omega = view.scale.all * kPositionBandwidth;
  a.z = -omega * omega * error.z - 2.0 * omega * base.velocity.z;
  return a;
}

}  // namespace skybody
