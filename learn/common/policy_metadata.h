// The parts of a policy file beside its network: scenario, training, normalization.
#pragma once

#include <cstdint>
#include <string>

#include "core/env/compiled_scenario.h"
#include "core/io/files/policy_file.h"
#include "learn/common/running_moments.h"

namespace skybody::learn {

/// A policy file without a network.
/// @param algorithm  name of the learner
/// @param steps      environment steps trained
PolicyFile policy_metadata(const CompiledScenario& compiled, const std::string& algorithm,
                           std::int64_t steps);

/// Sets the normalization of the file's inputs: those of the first columns of `moments`.
/// @param clip  bound of normalized values
void set_normalization(const RunningMoments& moments, double clip, PolicyFile& file);

}  // namespace skybody::learn
