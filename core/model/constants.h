// The tables of core/base/constants.h in C++: indices of values by name, and rows for loops.
// C++17.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>

#include "core/base/constants.h"

namespace skybody {

#define SKYBODY_PLACE_ID(SYMBOL, Id, key, unit, count, fallback, least, greatest, least_drawn, \
                         doc)                                                                  \
  Id = SYMBOL, Id##Last = SYMBOL##_LAST,

/// Indices of the values of one object, such as the index of a rotor's thrust constant counted from
/// the rotor's first EnvParam. `kComLast` is the index of the last of the values that begin at
/// `kCom`.
enum WorldParam : int { SKYBODY_WORLD_CONSTANTS(SKYBODY_PLACE_ID) kWorldParamCount };
enum RobotParam : int { SKYBODY_ROBOT_CONSTANTS(SKYBODY_PLACE_ID) kRobotParamCount };
enum BodyParam : int { SKYBODY_BODY_CONSTANTS(SKYBODY_PLACE_ID) kBodyParamCount };
enum JointParam : int { SKYBODY_JOINT_CONSTANTS(SKYBODY_PLACE_ID) kJointParamCount };
enum RotorParam : int { SKYBODY_ROTOR_CONSTANTS(SKYBODY_PLACE_ID) kRotorParamCount };
enum ObstacleParam : int { SKYBODY_OBSTACLE_CONSTANTS(SKYBODY_PLACE_ID) kObstacleParamCount };
enum CouplingParam : int { SKYBODY_COUPLING_CONSTANTS(SKYBODY_PLACE_ID) kCouplingParamCount };
#undef SKYBODY_PLACE_ID

/// One constant, with one or several values.
struct ConstantRow {
  int place;            ///< index of its first value among the object's values
  const char* key;      ///< in files and paths; "disturbance.force": in the map `disturbance`
  const char* unit;     ///< "": none
  int count;            ///< number of values
  bool is_required;     ///< files must give it
  double fallback[6];   ///< the default: the first `count` values, unless required
  double least;         ///< lower bound of each value in a file, inclusive
  double greatest;      ///< upper bound of each value in a file, inclusive
  double lowest_drawn;  ///< lower bound of each drawn value, inclusive
  const char* doc;      ///< one line

  /// Lower bound of value k of a drawn constant: products of inertia have either sign.
  constexpr double least_drawn(int k) const {
    return count == 6 && k >= 3 ? -INFINITY : lowest_drawn;
  }
};

#define SKYBODY_VALUES(...) \
  { __VA_ARGS__ }
#define SKYBODY_ROW(SYMBOL, Id, key, unit, count, fallback, least, greatest, least_drawn, doc) \
  ConstantRow{SYMBOL,                                                                          \
              key,                                                                             \
              unit,                                                                            \
              count,                                                                           \
              std::initializer_list<double> SKYBODY_VALUES fallback.size() == 0,               \
              SKYBODY_VALUES fallback,                                                         \
              least,                                                                           \
              greatest,                                                                        \
              least_drawn,                                                                     \
              doc},

inline constexpr std::array kWorldConstants{SKYBODY_WORLD_CONSTANTS(SKYBODY_ROW)};
inline constexpr std::array kRobotConstants{SKYBODY_ROBOT_CONSTANTS(SKYBODY_ROW)};
inline constexpr std::array kBodyConstants{SKYBODY_BODY_CONSTANTS(SKYBODY_ROW)};
inline constexpr std::array kJointConstants{SKYBODY_JOINT_CONSTANTS(SKYBODY_ROW)};
inline constexpr std::array kRotorConstants{SKYBODY_ROTOR_CONSTANTS(SKYBODY_ROW)};
inline constexpr std::array kObstacleConstants{SKYBODY_OBSTACLE_CONSTANTS(SKYBODY_ROW)};
inline constexpr std::array kCouplingConstants{SKYBODY_COUPLING_CONSTANTS(SKYBODY_ROW)};
#undef SKYBODY_ROW
#undef SKYBODY_VALUES

/// The default values of a table; 0 for required values.
template <int kCount, class Rows>
constexpr std::array<double, kCount> fallbacks(const Rows& rows) {
  std::array<double, kCount> values{};
  for (const ConstantRow& row : rows) {
    for (int k = 0; k < row.count; ++k) values[row.place + k] = row.fallback[k];
  }
  return values;
}

/// The row whose values begin at `place`.
template <class Rows>
constexpr const ConstantRow& row_at(const Rows& rows, int place) {
  std::size_t i = 0;
  while (rows[i].place != place) ++i;
  return rows[i];
}

}  // namespace skybody
