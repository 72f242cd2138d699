// Source of measured rates and accelerations: the state, or an IMU at the base's frame. Parameters
// `measured` and `imu`.
#pragma once

#include <skybody/plugin.h>

namespace skybody::control {

/// Declared as a member of the controller `owner`.
class MeasuredMotion {
 public:
  explicit MeasuredMotion(Plugin* owner)
      : measured_(owner, choice("measured", "state", {"state", "imu"},
                                "source of rates and accelerations")),
        imu_(owner, word("imu", "imu",
                         "measured: imu: name of the sensor, which must be at the base's frame")) {}

  /// @throws std::runtime_error if there is no such sensor
  void configure(const Setup& setup) {
    if (measured_.value() != "imu") return;
    force_ = setup.sensor(imu_.value(), "specific_force");
    rate_ = setup.sensor(imu_.value(), "angular_rate");
  }

  bool is_by_imu() const { return force_ >= 0; }
  /// Specific force, B axes [m/s^2]; of an IMU alone.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> specific_force(const EnvView<Real>& env) const {
    return sensed(env, force_);
  }
  /// Body rates [rad/s]. @param state  those of the state
  template <class Real>
  SKYBODY_INLINE Vec3<Real> rates(const EnvView<Real>& env, const Vec3<Real>& state) const {
    return is_by_imu() ? sensed(env, rate_) : state;
  }

 private:
  template <class Real>
  static SKYBODY_INLINE Vec3<Real> sensed(const EnvView<Real>& env, int first) {
    return {env.sensor(first), env.sensor(first + 1), env.sensor(first + 2)};
  }

  TextParameter measured_, imu_;
  int force_ = -1, rate_ = -1;
};

}  // namespace skybody::control
