// All that is known of the world at an instant: the values that a task may read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "onboard/mission.h"

namespace skybody::onboard {

inline constexpr int kBodyValues =
    13;  ///< position (W), quaternion w x y z, velocity (W), rate (B)

/// Pose and twist of a body.
struct Motion {
  Vec3<double> position{0.0, 0.0, 0.0};          ///< W [m]
  Quat<double> rotation{1.0, 0.0, 0.0, 0.0};     ///< W from B, w x y z
  Vec3<double> velocity{0.0, 0.0, 0.0};          ///< W [m/s]
  Vec3<double> angular_velocity{0.0, 0.0, 0.0};  ///< B [rad/s]

  /// Whether all values are finite and the quaternion has the length 1, to half a percent.
  bool is_valid() const;
  /// Angle between the z axes of B and W [rad].
  double tilt() const;
};

/// Measurements of an inertial measurement unit.
struct Imu {
  Vec3<double> specific_force{0.0, 0.0, 0.0};    ///< B [m/s^2]
  Vec3<double> angular_velocity{0.0, 0.0, 0.0};  ///< B [rad/s]
};

struct Situation {
  /// Nominal parameters, bodies at their start, all else zero.
  explicit Situation(const Mission& mission);

  std::uint64_t step = 0;          ///< actions taken
  std::uint64_t physics_step = 0;  ///< physics steps of the simulator that these would have been
  std::vector<double> bodies, q, u, rotor_speed, sensors, params;

  void set_body(int body, const Motion& motion);
  Motion body(int body) const;
  int body_count() const { return static_cast<int>(bodies.size()) / kBodyValues; }
  /// Sets the outputs of all sensors that have channels of an IMU.
  void set_imu(const Mission& mission, const Imu& imu);
  /// Sets parameters from `path` on, such as task.target. @returns whether there are so many
  bool set_param(const Mission& mission, std::string_view path, std::span<const double> values);
};

/// Whether a sensor's channel is one that an IMU gives.
bool is_of_imu(const SkybodySensorInfo& sensor);

}  // namespace skybody::onboard
