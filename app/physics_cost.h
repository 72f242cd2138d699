// What a physics step alone costs, for the share that it has in a measurement.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody {

/// Mean time of a physics step of one environment on this thread, flying with the commands of the
/// scenario's start [s]. Takes a few tenths of a second.
/// @param side_by_side  environments of a group, as Pool::lanes() says: alone, or in lanes
double physics_step_cost(const CompiledScenario& compiled, int side_by_side);

}  // namespace skybody
