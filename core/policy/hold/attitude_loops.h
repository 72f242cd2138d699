// The attitude and rate loops of the hold baseline, and their bandwidth limits from a vehicle's
// rotors.
#pragma once

#include <vector>

#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "core/model/state_layout.h"

namespace skybody {

/// Factors on the loops' bandwidths allowed by the rotors, 0 to 1: for all loops, and for the rate
/// about z.
struct BandwidthScale {
  double all = 1.0, yaw = 1.0;
};

/// With slow rotors, every loop is slower in proportion, so that all keep their damping. About z,
/// the reaction to a rotor's change of speed acts at once. It is larger than the rotor's drag by J
/// / (2 k_m w lag): it closes a loop of its own, in which a high gain is unstable.
/// @param params  of the environment
/// @param weight  carried by the robot's rotors [N]
BandwidthScale bandwidth_scale(const StateLayout& layout, const RobotLayout& robot,
                               const std::vector<double>& params, double weight);

/// Attitude (W from B) whose z axis lies along `up` (W, not zero) and whose heading is `yaw` [rad].
Quat<double> attitude_along(const Vec3<double>& up, double yaw);

/// Body rates [rad/s] that turn `now` towards `wanted`: proportional to the vector part of the
/// error.
Vec3<double> rates_towards(const Quat<double>& wanted, const Quat<double>& now,
                           const BandwidthScale& scale);

/// Torque [N m], B, that drives the rates [rad/s] to `wanted`: through the inertia [kg m^2],
/// gyroscopic part included.
Vec3<double> torque_for(const Vec3<double>& wanted, const Vec3<double>& rates,
                        const SymMat3<double>& inertia, const BandwidthScale& scale);

}  // namespace skybody
