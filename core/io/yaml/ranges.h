// Ranges of numbers in files.
//
// They are wide enough for every flying robot. They are narrow enough that squares and products of
// several numbers stay well inside the range in which doubles have full precision (2e-308 to
// 1.8e308). docs/scenarios.md has the table.
#pragma once

#include <cmath>
#include <string>

#include "core/io/files/text.h"

namespace skybody {

/// Bound of positions [m] and of other quantities without a natural bound.
inline constexpr double kFar = 1e6;
/// Smallest edge or radius [m]; the size of an atom is 1e-10.
inline constexpr double kSmallestLength = 1e-9;
/// Largest roll, pitch or yaw angle [rad]; larger ones only lose precision.
inline constexpr double kMostTurned = 1000.0;
/// Shortest axis: its square must keep full precision.
inline constexpr double kShortestAxis = 1e-6;
/// Longest name [bytes]; names are parts of paths of parameters.
inline constexpr std::size_t kLongestName = 200;

/// Allowed magnitudes of a number.
struct Range {
  double smallest;
  double largest;
  const char* unit;
  bool zero = false;   ///< 0 is also allowed
  bool signs = false;  ///< negative numbers are also allowed

  bool has(double value) const {
    if (value < 0.0 && !signs) return false;
    const double size = std::fabs(value);
    return (zero && size == 0.0) || (size >= smallest && size <= largest);
  }

  /// "0, or from 1e-20 to 1e+12 kg".
  std::string text() const {
    const std::string upper = format_number(largest) + (unit[0] == '\0' ? "" : " ") + unit;
    if (signs && smallest == 0.0) return "from -" + format_number(largest) + " to " + upper;
    return (zero && smallest > 0.0 ? "0, or from " : "from ") + format_number(smallest) + " to " +
           upper + (signs ? ", with either sign" : "");
  }
};

/// Exporters give links that only mark a place a mass of 1e-9 kg or less.
inline constexpr Range kMassRange{1e-20, 1e12, "kg", true};
/// Diagonal elements; lower bound as for masses. Cubes, as in a determinant, keep full precision.
inline constexpr Range kInertiaRange{1e-40, 1e24, "kg m^2", true, true};
/// Off-diagonal elements: exporters write round-off errors.
inline constexpr Range kProductRange{0.0, 1e24, "kg m^2", true, true};
inline constexpr Range kPlaceRange{0.0, kFar, "m", true, true};
inline constexpr Range kTurnRange{0.0, kMostTurned, "rad", true, true};
inline constexpr Range kSizeRange{kSmallestLength, kFar, "m"};
/// A time constant: dt divided by it must stay finite.
inline constexpr Range kLagRange{1e-9, 100.0, "s", true};
inline constexpr Range kScaleRange{0.0, kFar, "", true, true};
inline constexpr Range kAxisRange{0.0, kFar, "", true, true};
/// Exporters write 1e16 for joints without a limit.
inline constexpr Range kTravelRange{0.0, 1e18, "rad or m", true, true};
inline constexpr Range kDampingRange{0.0, kFar, "N m s/rad or N s/m", true};

}  // namespace skybody
