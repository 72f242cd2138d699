// Errors that the filter assumes of its sources and of its first estimate.
#pragma once

#include <skybody/plugin.h>

namespace skybody::ekf {

/// Parameters of the filter; a larger deviation gives a source less weight.
class Tuning {
 public:
  explicit Tuning(Plugin* owner) : owner_(owner) {}

 private:
  RealParameter tuned(const char* name, const char* unit, double value, const char* doc) const {
    return RealParameter(owner_, when_given(real(name, unit, value, between(1e-9, 1e9), doc)));
  }
  Plugin* owner_;

 public:
  RealParameter force_noise =
      tuned("accelerometer_noise", "m/s^2/sqrt(Hz)", 0.01, "assumed density of the white noise");
  RealParameter rate_noise =
      tuned("gyroscope_noise", "rad/s/sqrt(Hz)", 1e-3, "assumed density of the white noise");
  RealParameter force_walk = tuned("accelerometer_walk", "m/s^3/sqrt(Hz)", 1e-3,
                                   "assumed density of the bias's random walk");
  RealParameter rate_walk = tuned("gyroscope_walk", "rad/s^2/sqrt(Hz)", 1e-4,
                                  "assumed density of the bias's random walk");
  RealParameter position_noise =
      tuned("pose_position_noise", "m", 2e-3, "assumed deviation of `pose`, per axis");
  RealParameter rotation_noise =
      tuned("pose_rotation_noise", "rad", 0.01, "assumed deviation of `pose`, per axis");
  RealParameter horizontal_noise =
      tuned("gnss_horizontal_noise", "m", 0.5, "assumed deviation of `gnss` along x and y");
  RealParameter vertical_noise =
      tuned("gnss_vertical_noise", "m", 1.0, "assumed deviation of `gnss` along z");
  RealParameter velocity_noise =
      tuned("gnss_velocity_noise", "m/s", 0.1, "assumed deviation of `gnss`, per axis");
  RealParameter altitude_noise =
      tuned("altitude_noise", "m", 0.3, "assumed deviation of `barometer`");
  RealParameter altitude_walk =
      tuned("altitude_walk", "m/sqrt(s)", 0.01,
            "assumed density of the random walk of the barometer's altitude");
  RealParameter field_noise =
      tuned("field_noise", "uT", 1.0, "assumed deviation of `magnetometer`, per axis");
  RealParameter first_position =
      tuned("initial_position", "m", 0.5, "assumed deviation at a reset, per axis");
  RealParameter first_velocity =
      tuned("initial_velocity", "m/s", 0.5, "assumed deviation at a reset, per axis");
  RealParameter first_rotation =
      tuned("initial_rotation", "rad", 0.05, "assumed deviation at a reset, per axis");
  RealParameter first_force_bias =
      tuned("initial_accelerometer_bias", "m/s^2", 0.2, "assumed deviation at a reset, per axis");
  RealParameter first_rate_bias =
      tuned("initial_gyroscope_bias", "rad/s", 0.02, "assumed deviation at a reset, per axis");
};

}  // namespace skybody::ekf
