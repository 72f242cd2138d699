// Warnings about possible but unlikely values, derived from several places of a scenario's files.
#pragma once

#include "core/env/compiled_scenario.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Warns of rotors, inertias and shapes of robots outside their usual ranges
/// (core/io/yaml/plausibility_limits.h), with nominal values and joints at their initial positions.
/// Robots with the same findings share one warning.
void warn_of_implausible_parameters(const CompiledScenario& compiled, Diagnostics& diagnostics);

}  // namespace skybody
