// Three sensitive axes of an accelerometer or a gyroscope: scale, misalignment, instability of the
// bias, resolution and range.
#pragma once

#include <skybody/plugin.h>

#include "sensors/common/errors.h"
#include "sensors/common/settings.h"
#include "sensors/imu/presets.h"

namespace skybody::imu {

/// Names of the parameters of one triad, and their units.
struct TriadNames {
  const char *scale, *misalignment, *instability, *range, *resolution, *unit;
};

inline constexpr TriadNames kAccelerometer{
    "accelerometer_scale", "accelerometer_misalignment", "accelerometer_instability",
    "accelerometer_range", "accelerometer_resolution",   "m/s^2"};
inline constexpr TriadNames kGyroscope{"gyroscope_scale",       "gyroscope_misalignment",
                                       "gyroscope_instability", "gyroscope_range",
                                       "gyroscope_resolution",  "rad/s"};

/// Errors that cost nothing unless a scenario or a preset sets them.
class Triad {
 public:
  Triad(Plugin* owner, const TriadNames& n)
      : scale_(owner, when_given(reals(n.scale, "", {0.0, 0.0, 0.0}, between(-1.0, 1.0),
                                       "errors of the scale factors of x, y, z"))),
        misalignment_(
            owner, when_given(reals(n.misalignment, "rad", {0.0, 0.0, 0.0}, between(-0.5, 0.5),
                                    "small rotation of the sensitive axes against the sensor's"))),
        instability_(owner, sensor::error_size(n.instability, n.unit,
                                               "standard deviation of the bias that wanders within "
                                               "`instability_time`")),
        range_(owner,
               sensor::error_size(n.range, n.unit, "greatest magnitude of a reading; 0: no limit")),
        resolution_(owner, sensor::error_size(n.resolution, n.unit,
                                              "readings are multiples of this; 0: not rounded")) {}

  void configure(const TriadPreset& preset) {
    preset_ = preset;
    is_distorted_ = scale_.is_given() || misalignment_.is_given();
    is_digital_ = is_set(range_, preset.range) || is_set(resolution_, preset.resolution);
    is_unstable_ = is_set(instability_, preset.instability);
  }

  bool is_unstable() const { return is_unstable_; }

  /// Standard deviation of the wandering bias.
  template <class Real>
  SKYBODY_INLINE Real instability(const EnvView<Real>& env) const {
    return value(instability_, preset_.instability, env);
  }
  /// Scale and misalignment applied to the true value.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> distorted(const EnvView<Real>& env, const Vec3<Real>& v) const {
    if (!is_distorted_) return v;
    const Vec3<Real> seen = v + cross(v, misalignment_.vec3(env));
    return seen + multiply_elements(scale_.vec3(env), seen);
  }
  /// Resolution, then range.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> digitized(const EnvView<Real>& env, const Vec3<Real>& v) const {
    if (!is_digital_) return v;
    const Real resolution = value(resolution_, preset_.resolution, env);
    const Real range = value(range_, preset_.range, env);
    const auto read = [&](const Real& x) {
      return sensor::saturated(sensor::quantized(x, resolution), range);
    };
    return {read(v.x), read(v.y), read(v.z)};
  }

 private:
  static bool is_set(const RealParameter& given, double preset) {
    return given.is_given() || preset > 0.0;
  }
  template <class Real>
  static SKYBODY_INLINE Real value(const RealParameter& given, double preset,
                                   const EnvView<Real>& env) {
    return given.is_given() ? given(env) : Real(preset);
  }

  RealsParameter scale_, misalignment_;
  RealParameter instability_, range_, resolution_;
  TriadPreset preset_{};
  bool is_distorted_ = false, is_digital_ = false, is_unstable_ = false;
};

}  // namespace skybody::imu
