// The declaration of one value: what it is called, what it may be and what it is when nobody says.
// Keys of scenario files and parameters of plugins are declared with the same struct; validation,
// documentation tables and the JSON schema come from it. C++17.
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
  int max_count = 1;                       ///< most entries; -1: any number
  std::vector<double> default_numbers;     ///< reals, integers, booleans as 0 and 1
  std::vector<std::string> default_texts;  ///< texts
  bool required = false;                   ///< no default: an error where it is missing
  double min = -std::numeric_limits<double>::infinity();  ///< of every entry, inclusive
  double max = std::numeric_limits<double>::infinity();   ///< of every entry, inclusive
  bool min_exclusive = false;                             ///< `min` itself is not allowed
  std::vector<std::string> choices;                       ///< of texts; empty: any
  bool is_file = false;       ///< texts are names of files, and values are their paths
  bool randomizable = false;  ///< one value per environment, drawn by randomizers

  /// Whether the value is written as one scalar rather than as a list.
  bool is_scalar() const { return min_count == 1 && max_count == 1; }
};

}  // namespace skybody
