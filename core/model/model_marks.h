// Locations of a robot's values in its files, for messages. Readers fill them in. C++17.
#pragma once

#include <array>
#include <vector>

#include "core/model/constants.h"
#include "core/model/source_location.h"

namespace skybody {

/// Locations of the values of one body.
struct BodyMarks {
  SourceLocation mass;                                 ///< of its heaviest link
  SourceLocation inertia;                              ///< of its heaviest link
  std::vector<SourceLocation> collisions;              ///< one per collision shape
  std::array<SourceLocation, kJointParamCount> joint;  ///< of given kJointConstants
};

/// Locations of the values of one rotor. A value that the file leaves out has the location of the
/// rotor's entry.
struct RotorMarks {
  std::array<SourceLocation, kRotorParamCount> constants;  ///< of kRotorConstants
  SourceLocation min_speed;
};

/// In the order of the model's bodies and rotors.
struct ModelMarks {
  std::vector<BodyMarks> bodies;
  std::vector<RotorMarks> rotors;
};

}  // namespace skybody
