// What a physics step alone costs, for the share that it has in a measurement.
#pragma once

#include "core/env/environment.h"

namespace skybody {

/// Mean time of a physics step of one environment on this thread, flying with the commands of the
/// scenario's start [s]. Takes a few tenths of a second.
/// @param lanes  environments that are stepped side by side, as VecEnv::lanes() says: 1 or 8
double physics_step_cost(const Environment& environment, int lanes);

}  // namespace skybody
