// Values of a scenario that are possible and unlikely: derived from several places of its files.
#pragma once

#include "core/env/compiled_scenario.h"
#include "core/io/diagnostics.h"

namespace skybody {

/// Warns of rotors, inertias and shapes of robots that are beyond their usual ranges
/// (core/io/plausibility_limits.h), by nominal values and with joints where an episode begins.
/// Robots that are alike get one warning.
void warn_of_implausible_parameters(const CompiledScenario& compiled, Diagnostics& diagnostics);

}  // namespace skybody
