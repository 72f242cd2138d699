// Inputs and setpoints of the hold baseline's loops for one robot.
#pragma once

#include <vector>

#include "core/base/math/vec3.h"
#include "core/policy/hold/attitude_loops.h"
#include "core/policy/hold/hold_policy.h"

namespace skybody {

/// The loops' setpoints, before conversion to the control mode's command.
struct HoldPolicy::Setpoint {
  Vec3<double> position{0.0, 0.0, 0.0};      // of the goal, W [m]
  Vec3<double> velocity{0.0, 0.0, 0.0};      // of the goal, W [m/s]
  Vec3<double> acceleration{0.0, 0.0, 0.0};  // of the goal, W [m/s^2]
  double yaw = 0.0;                          // of the goal [rad]
  Vec3<double> force{0.0, 0.0, 0.0};         // on the whole robot, W [N]
  double thrust = 0.0;                       // collective, along the body's z [N]
  Quat<double> attitude{1.0, 0.0, 0.0, 0.0};
  Vec3<double> rates{0.0, 0.0, 0.0};   // B [rad/s]
  Vec3<double> torque{0.0, 0.0, 0.0};  // B [N m]
  std::vector<double> reach;           // positions of the arm's joints [rad] or [m]
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

/// A vector, shortened to length `most` if it is longer.
inline Vec3<double> shortened(const Vec3<double>& v, double most) {
  const double n = norm(v);
  return n > most ? v * (most / n) : v;
}

/// Gain from a position error to a speed [rad/s]: about four times slower than the loop inside it
/// (attitude_loops.cpp).
inline constexpr double kPositionBandwidth = 2.0;
/// Limits the speed of long flights to 1.5 m/s [m].
inline constexpr double kMaxError = 1.5;

}  // namespace skybody
