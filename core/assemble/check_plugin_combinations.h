// What plugins of one scenario must not do beside one another. Each is right by itself, and knows
// nothing of the others when it is configured.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody {

/// Refuses a randomizer `start` with `rotor_speed: hover` ahead of one that draws what hovering
/// takes, and two effects that give one robot a second battery, or second motors.
/// @throws LocatedError at the scenario's line
void check_plugin_combinations(const CompiledScenario& compiled);

}  // namespace skybody
