// Measures the time of a physics step alone, for its share in a measurement.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody {

/// Mean time of a physics step of one environment on this thread, with the commands of the
/// scenario's start [s]. Takes a few tenths of a second.
/// @param side_by_side  environments of a group, from Pool::lanes(): one, or several in lanes
double physics_step_cost(const CompiledScenario& compiled, int side_by_side);

}  // namespace skybody
