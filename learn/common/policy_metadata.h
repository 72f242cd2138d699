// The header of a policy file: its scenario and its training.
#pragma once

#include <cstdint>

#include "core/env/compiled_scenario.h"
#include "core/io/files/policy_file.h"
#include "learn/hyperparameters.h"

namespace skybody::learn {

/// A policy file without a network.
/// @param steps  environment steps trained
PolicyFile policy_metadata(const CompiledScenario& compiled, Algorithm algorithm,
                           std::int64_t steps);

}  // namespace skybody::learn
