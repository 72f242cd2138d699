// The head of a policy file: which scenario it flies, and how it came about.
#pragma once

#include <cstdint>

#include "core/env/compiled_scenario.h"
#include "core/io/policy_file.h"
#include "learn/hyperparameters.h"

namespace skybody::learn {

/// A policy without a network.
/// @param steps  environment steps trained
PolicyFile policy_metadata(const CompiledScenario& compiled, Algorithm algorithm,
                           std::int64_t steps);

}  // namespace skybody::learn
