#include "onboard/safe_command.h"

#include <algorithm>
#include <cmath>

#include "core/plugin_abi/signals.h"

namespace skybody::onboard {
namespace {

constexpr double kLevelGain = 4.0;     // of the tilt [rad/s per rad]
constexpr double kLevelRate = 2.0;     // greatest rate about an axis [rad/s]
constexpr double kDescentSpeed = 0.5;  // [m/s]

double heading(const Quat<double>& q) {
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

/// Body rates that turn z of B upwards [rad/s].
Vec3<double> level_rates(const Quat<double>& q) {
  const Vec3<double> up = rotate_inverse(q, Vec3<double>{0.0, 0.0, 1.0});
  const auto rate = [](double value) {
    return std::clamp(kLevelGain * value, -kLevelRate, kLevelRate);
  };
  return {rate(-up.y), rate(up.x), 0.0};  // B's z axis x up, both in B
}

void put(std::span<double> command, std::initializer_list<double> values) {
  std::copy_n(values.begin(), std::min(values.size(), command.size()), command.begin());
}

}  // namespace

bool can_descend(int signal) {
  switch (signal) {
    case SKYBODY_CTBR:
    case SKYBODY_ATTITUDE:
    case SKYBODY_FORCE:
    case SKYBODY_ACCELERATION:
    case SKYBODY_VELOCITY_TRACKING:
      return true;
    default:
      return false;
  }
}

void stop_command(const Mission& mission, std::span<double> command) {
  std::fill(command.begin(), command.end(), 0.0);
  if (mission.chain().signal == SKYBODY_ATTITUDE) put(command, {0.0, 1.0});
  if (mission.chain().signal == SKYBODY_ACCELERATION) put(command, {0.0, 0.0, -mission.gravity()});
}

void descend_command(const Mission& mission, const Motion& motion, bool is_fresh,
                     std::span<double> command) {
  const double weight = mission.mass() * mission.gravity();
  const double thrust = mission.limits.safe_thrust * weight, yaw = heading(motion.rotation);
  std::fill(command.begin(), command.end(), 0.0);
  switch (mission.chain().signal) {
    case SKYBODY_CTBR: {
      const Vec3<double> rates =
          is_fresh ? level_rates(motion.rotation) : Vec3<double>{0.0, 0.0, 0.0};
      put(command, {thrust, rates.x, rates.y, rates.z});
      return;
    }
    case SKYBODY_ATTITUDE:
      put(command, {thrust, std::cos(0.5 * yaw), 0.0, 0.0, std::sin(0.5 * yaw)});
      return;
    case SKYBODY_FORCE:
      put(command, {0.0, 0.0, thrust, yaw});
      return;
    case SKYBODY_ACCELERATION:
      put(command, {0.0, 0.0, (mission.limits.safe_thrust - 1.0) * mission.gravity(), yaw});
      return;
    case SKYBODY_VELOCITY_TRACKING:
      put(command, {0.0, 0.0, -kDescentSpeed, 0.0});
      return;
    default:
      stop_command(mission, command);
  }
}

}  // namespace skybody::onboard
