// Builds the list of an environment's state values. For StateValues alone.
#pragma once

#include <vector>

#include "core/env/state_values.h"

namespace skybody {

/// In the order of StateValues::all(). A path may occur twice: the first one counts.
std::vector<StateValue> list_state_values(const CompiledScenario& compiled);

}  // namespace skybody
