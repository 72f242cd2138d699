#include "core/policy/hold/attitude_loops.h"

#include <algorithm>

#include "core/base/math/math.h"

namespace skybody {
namespace {

// Gains [1/s]: each loop is about four times slower than the one inside it, starting at the rotors'
// own 40 to 80 rad/s.
constexpr double kAttitudeGain = 8.0;
constexpr double kYawGain = 2.0;
constexpr double kRateGain = 25.0;
constexpr double kQuickLag = 0.025;     // [s]: rotor lag up to which these gains hold
constexpr double kLeastLag = 0.005;     // [s]: the mean age of a command at 100 Hz
constexpr double kYawCrossover = 65.0;  // [rad/s]: highest for the rate about z, at 100 Hz

using V = Vec3<double>;

}  // namespace

Quat<double> attitude_along(const V& up, double yaw) {
  const V z = up / norm(up);
  const SinCos<double> heading = sincos(yaw);
  V y = cross(z, V{heading.cos, heading.sin, 0.0});
  y = y / norm(y);
  const V x = cross(y, z);
  return from_rotation(Mat3<double>{{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z}});
}

V rates_towards(const Quat<double>& wanted, const Quat<double>& now, const BandwidthScale& scale) {
  const Quat<double> e = conjugate(now) * wanted;
  const double sign = e.w < 0.0 ? -2.0 : 2.0;
  const double tilt = sign * scale.all, yaw = sign * std::min(scale.all, 4.0 * scale.yaw);
  return {kAttitudeGain * tilt * e.x, kAttitudeGain * tilt * e.y, kYawGain * yaw * e.z};
}

V torque_for(const V& wanted, const V& rates, const SymMat3<double>& inertia,
             const BandwidthScale& scale) {
  const double tilt = kRateGain * scale.all, yaw = kRateGain * scale.yaw;
  const V change = wanted - rates;
  return inertia * V{tilt * change.x, tilt * change.y, yaw * change.z} +
         cross(rates, inertia * rates);
}

BandwidthScale bandwidth_scale(const StateLayout& layout, const RobotLayout& robot,
                               const std::vector<double>& params, double weight) {
  if (robot.rotor_count == 0) return {};
  double lag = 0.0, inertia = 0.0, drag = 0.0, lift = 0.0;
  for (int i = robot.first_rotor; i < robot.first_rotor + robot.rotor_count; ++i) {
    const double* rotor = params.data() + layout.rotor_params[static_cast<std::size_t>(i)];
    lag += std::max(rotor[kTauUp], rotor[kTauDown]) / robot.rotor_count;
    inertia += rotor[kRotorInertia];
    drag += rotor[kMomentConstant];
    lift += rotor[kThrustConstant];
  }
  BandwidthScale scale;
  if (lag > kQuickLag) scale.all = kQuickLag / lag;
  scale.yaw = scale.all;
  // With T = J / (2 k_m w), the loop of gain K crosses 1 at T K / lag. The lag has a minimum,
  // because commands are held.
  const double twice_momentum = 2.0 * drag * sqrt(weight / lift);
  const double least = kYawCrossover * std::max(lag, kLeastLag);
  if (kRateGain * scale.yaw * inertia > least * twice_momentum) {
    scale.yaw = least * twice_momentum / (kRateGain * inertia);
  }
  return scale;
}

}  // namespace skybody
