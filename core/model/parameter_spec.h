// The declaration of one value: name, unit, type, range and default. Keys of scenario files and
// parameters of plugins use the same struct; validation, documentation tables and the JSON schema
// are generated from it. C++17.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/model/scenario.h"

namespace skybody {

/// Declares one named value: a scalar (min_count = max_count = 1) or a list.
struct ParameterSpec {
  std::string name;
  std::string unit;  ///< such as "rad/s"; empty: none
  std::string doc;   ///< one line
  ParameterType type = ParameterType::kReal;
  int min_count = 1;                       ///< least number of entries
  int max_count = 1;                       ///< largest number of entries; -1: unlimited
  std::vector<double> default_numbers;     ///< reals, integers, booleans as 0 and 1
  std::vector<std::string> default_texts;  ///< texts
  bool required = false;                   ///< no default: a missing value is an error
  double min = -std::numeric_limits<double>::infinity();  ///< of every entry, inclusive
  double max = std::numeric_limits<double>::infinity();   ///< of every entry, inclusive
  bool min_exclusive = false;                             ///< excludes `min` itself
  std::vector<std::string> choices;                       ///< of texts; empty: any
  bool is_file = false;       ///< texts are names of files; values are their paths
  bool randomizable = false;  ///< one value per environment, which randomizers may draw
  bool when_given = false;    ///< randomizable only where the scenario sets it

  /// Whether the value is written as one scalar rather than as a list.
  bool is_scalar() const { return min_count == 1 && max_count == 1; }
};

}  // namespace skybody
