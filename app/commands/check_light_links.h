// Detects links that are much lighter than their load: when the load swings, they move faster than
// the step can follow.
#pragma once

#include "core/env/compiled_scenario.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Warns, once per robot, of joints whose links respond to the weight of their load faster than
/// fixed steps of this scenario's `dt` can follow.
void warn_of_light_links(const CompiledScenario& compiled, Diagnostics& diagnostics);

}  // namespace skybody
