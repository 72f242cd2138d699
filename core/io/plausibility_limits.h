// Values that are possible and that nobody flies: the usual ranges, and the mistakes that explain a
// value beyond one. One table, which everything that reads or derives such a value asks.
#pragma once

#include <initializer_list>
#include <string>

#include "core/io/diagnostics.h"

namespace skybody {

/// What has a usual range, in the order of the table in plausibility_limits.cpp.
enum class PlausibilityLimit {
  kAngle,           ///< any number in rad
  kHeight,          ///< of the ground [m]
  kGravity,         ///< along z of W [m/s^2]
  kThrustToWeight,  ///< all rotors at their largest speed, by the robot's weight
  kMomentArm,       ///< drag torque by thrust, k_m / k_f [m]
  kLag,             ///< time constant of a rotor [s]
  kGyration,        ///< radius of gyration of what carries the rotors, by the longest arm
  kSize,            ///< greatest length of a collision shape [m]
  kArm              ///< of a hub from the centre of mass of the robot's base [m]
};

/// A value from a file that made what is looked at.
struct GivenValue {
  const char* key;
  double value;
  double factor = 1.0;  ///< by which the factor of a mistake in the table is multiplied
};

/// Whether a value is in its usual range.
bool is_plausible(PlausibilityLimit what, double value);

/// A warning for a value that is not: the value, the range, and what was meant if one of the known
/// mistakes explains it.
/// @param name   what it is and whose, to begin the message
/// @param given  values that made it; empty: it stands in the file itself
void warn_if_implausible(PlausibilityLimit what, double value, const std::string& name,
                         std::initializer_list<GivenValue> given, const SourceLocation& mark,
                         Diagnostics& diagnostics);

}  // namespace skybody
