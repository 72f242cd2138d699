// The International Standard Atmosphere up to 11 km (ISO 2533:1975).
#pragma once

#include <skybody/plugin.h>

namespace skybody::sensor {

inline constexpr double kSeaLevelPressure = 101325.0;   ///< [Pa]
inline constexpr double kSeaLevelTemperature = 288.15;  ///< [K]
inline constexpr double kLapseRate = 0.0065;            ///< [K/m]
inline constexpr double kEarthRadius = 6356766.0;       ///< [m]
/// g / (R L) with g = 9.80665 m/s^2 and R = 287.05287 J/(kg K).
inline constexpr double kPressureExponent = 9.80665 / (287.05287 * kLapseRate);

/// Pressure over that of sea level, at a geometric altitude [m] of up to 11 km.
/// @param temperature  at sea level [K]
template <class Real>
SKYBODY_INLINE Real pressure_ratio(const Real& altitude, const Real& temperature) {
  const Real height = kEarthRadius * altitude / (kEarthRadius + altitude);  // geopotential
  const Real ratio = max(1.0 - kLapseRate * height / temperature, 1e-3);
  return exp(kPressureExponent * log(ratio));
}

/// Geopotential altitude of a pressure in the standard atmosphere [m].
template <class Real>
SKYBODY_INLINE Real pressure_altitude(const Real& pressure) {
  const Real ratio = max(pressure / kSeaLevelPressure, 1e-6);
  return (kSeaLevelTemperature / kLapseRate) * (1.0 - exp(log(ratio) / kPressureExponent));
}

}  // namespace skybody::sensor
