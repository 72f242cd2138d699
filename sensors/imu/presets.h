// Errors of four inertial sensors by their datasheets; README.md has the sources.
#pragma once

#include <string>

#include "core/base/math/math_basic.h"

namespace skybody::imu {

/// Errors of one triad; 0: none.
struct TriadPreset {
  double noise = 0.0;        ///< density [unit/sqrt(Hz)]
  double bias = 0.0;         ///< standard deviation at a reset [unit]
  double instability = 0.0;  ///< standard deviation of the Gauss-Markov process [unit]
  double range = 0.0;        ///< [unit]
  double resolution = 0.0;   ///< [unit]
};

/// Errors of an inertial measurement unit.
struct Preset {
  TriadPreset accelerometer;   ///< m/s^2
  TriadPreset gyroscope;       ///< rad/s
  double g_sensitivity = 0.0;  ///< [rad/s / (m/s^2)]
};

inline constexpr double kG = 9.80665, kMilliG = 1e-3 * kG;
inline constexpr double kDegree = kPi / 180.0, kDegreePerHour = kDegree / 3600.0;
/// Greatest Allan deviation of a Gauss-Markov process over its standard deviation.
inline constexpr double kAllanPeak = 0.617;

inline constexpr Preset kBmi088{{0.160 * kMilliG, 20.0 * kMilliG, 0.0, 24.0 * kG, kG / 1365.0},
                                {0.014 * kDegree, 1.0 * kDegree, 2.0 * kDegreePerHour / kAllanPeak,
                                 2000.0 * kDegree, kDegree / 16.384},
                                0.1 * kDegree / kG};
inline constexpr Preset kIcm42688{
    {0.065 * kMilliG, 20.0 * kMilliG, 0.0, 16.0 * kG, kG / 2048.0},
    {0.0028 * kDegree, 0.5 * kDegree, 0.0, 2000.0 * kDegree, kDegree / 16.4},
    0.0};
inline constexpr Preset kMpu6000{
    {0.400 * kMilliG, 50.0 * kMilliG, 0.0, 16.0 * kG, kG / 2048.0},
    {0.005 * kDegree, 20.0 * kDegree, 0.0, 2000.0 * kDegree, kDegree / 16.4},
    0.1 * kDegree / kG};
inline constexpr Preset kAdis16448{
    {0.230 * kMilliG, 20.0 * kMilliG, 0.25 * kMilliG / kAllanPeak, 18.0 * kG, 0.833 * kMilliG},
    {0.0135 * kDegree, 0.5 * kDegree, 14.5 * kDegreePerHour / kAllanPeak, 1000.0 * kDegree,
     0.04 * kDegree},
    0.015 * kDegree / kG};

/// The preset of that name; without errors if the name is `none`.
inline Preset preset_called(const std::string& name) {
  if (name == "bmi088") return kBmi088;
  if (name == "icm42688") return kIcm42688;
  if (name == "mpu6000") return kMpu6000;
  if (name == "adis16448") return kAdis16448;
  return {};
}

}  // namespace skybody::imu
