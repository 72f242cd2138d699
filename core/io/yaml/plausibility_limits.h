// Usual ranges of parameters, and the mistakes that explain values outside of them. A value outside
// its usual range is possible but unlikely. All readers and derived checks share this table.
#pragma once

#include <initializer_list>
#include <string>

#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Quantities with a usual range, in the order of the table in plausibility_limits.cpp.
enum class PlausibilityLimit {
  kAngle,           ///< any number in rad
  kHeight,          ///< of the ground [m]
  kGravity,         ///< along z of W [m/s^2]
  kThrustToWeight,  ///< all rotors at their largest speed, divided by the robot's weight
  kHoverShare,      ///< hover thrust of the least loaded rotor, divided by the largest
  kMomentArm,       ///< drag torque divided by thrust, k_m / k_f [m]
  kLag,             ///< time constant of a rotor [s]
  kGyration,        ///< radius of gyration of the body with the rotors, divided by the longest arm
  kSize,            ///< greatest length of a collision shape [m]
  kArm,             ///< distance of a hub from the centre of mass of the robot's base [m]
  kArmByMass        ///< the arm, divided by the cube root of the mass [m/kg^(1/3)]
};

/// A value from a file or an option that determines the checked value.
struct GivenValue {
  const char* key;  ///< in the file, or the option, such as --mass
  double value;
  SourceLocation mark = {};  ///< no file: unknown
  double factor = 1.0;       ///< multiplies the factor of a mistake in the table
};

/// Whether a value is in its usual range.
bool is_plausible(PlausibilityLimit what, double value);

/// Warns of a value outside its usual range, with the value, the range, and the intended value if a
/// known mistake explains it. The warning is at the mistaken value, else at the first of `given`
/// whose location is known, else at `mark`.
/// @param name   the quantity and its owner, at the start of the message
/// @param given  values that determine it; empty: the file contains it directly
void warn_if_implausible(PlausibilityLimit what, double value, const std::string& name,
                         std::initializer_list<GivenValue> given, const SourceLocation& mark,
                         Diagnostics& diagnostics);

}  // namespace skybody
