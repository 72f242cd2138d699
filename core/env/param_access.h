// Reading and writing EnvParams by path.
#pragma once

#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody {

/// The parameters that a path names, as randomizers name them (docs/scenarios.md), in order.
/// @throws Error if there are none
std::vector<int> find_params(const Scenario& scenario, const Layout& layout,
                             const std::string& path);

/// What a message adds about a path that names nothing: "; did you mean `x`?" with the one that is
/// spelled most like it (of vectors without an index), and where all of them are listed.
std::string nearest_param(const Layout& layout, const std::string& path);

/// Refuses a list of `count` values for a path that names something else than vectors of so many.
/// @throws Error with the size that is needed
void check_vector_size(const Scenario& scenario, const Layout& layout, const std::string& path,
                       std::size_t count);

/// Refuses one number for a path that names a vector without an index: of gravity, x, y and z would
/// all become it. @throws Error with the size and the first index
void check_one_value(const Scenario& scenario, const Layout& layout, const std::string& path);

/// Value of a randomizable parameter in one lane. @throws Error if there is none at `path`
double get_param(const CompiledScenario& compiled, const StateGroup& group, int lane,
                 const std::string& path);

/// Sets one. @throws Error if unknown or outside its bounds
void set_param(const CompiledScenario& compiled, StateGroup& group, int lane,
               const std::string& path, double value);

}  // namespace skybody
