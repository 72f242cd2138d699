// Reading and writing EnvParams by path.
#pragma once

#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody {

/// The parameters that match a path, in the notation of randomizers (docs/scenarios.md), in order.
/// @throws Error if there are none
std::vector<int> find_params(const Scenario& scenario, const StateLayout& layout,
                             const std::string& path);

/// The end of a message about a path that names nothing: "; did you mean `x`?" with the most
/// similar path (for vectors without an index), and the place where all paths are listed.
std::string nearest_param(const StateLayout& layout, const std::string& path);

/// Checks a list of `count` values: the path must name vectors of that size only.
/// @throws Error with the required size
void check_vector_size(const Scenario& scenario, const StateLayout& layout, const std::string& path,
                       std::size_t count);

/// Rejects one number for a path that names a vector without an index: for gravity, x, y and z
/// would all get it. @throws Error with the size and the first index
void check_one_value(const Scenario& scenario, const StateLayout& layout, const std::string& path);

/// Value of a randomizable parameter in one lane. @throws Error if `path` names none
double get_param(const CompiledScenario& compiled, const StateGroup& group, int lane,
                 const std::string& path);

/// Sets a randomizable parameter. @throws Error if the path is unknown or the value out of bounds
void set_param(const CompiledScenario& compiled, StateGroup& group, int lane,
               const std::string& path, double value);

}  // namespace skybody
