// Checks of combinations of plugins. Each plugin is valid on its own and has no information about
// the others when it is configured.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody {

/// Rejects two combinations:
/// - a randomizer `start` with `rotor_speed: hover` before a randomizer that changes the hover
///   speed
/// - two effects that give one robot a second battery or second motors
/// @throws LocatedError at the scenario's line
void check_plugin_combinations(const CompiledScenario& compiled);

}  // namespace skybody
