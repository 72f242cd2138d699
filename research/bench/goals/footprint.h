// Cost of an environment: memory, and the time of a reset.
#pragma once

#include <string>

#include "core/assemble/compile_scenario.h"

namespace skybody::bench {

/// Resident memory per environment of a Pool with `envs`, including rows and buffers [bytes].
double bytes_per_environment(const LoadOptions& scenario, int envs);

/// Best time of a reset, all lanes of a group together [s per environment].
double reset_time(const LoadOptions& scenario);

/// Best time to rebuild a hand-written Simbody world with another mass [s].
double bare_rebuild_time();

}  // namespace skybody::bench
