// Links that are light beside what hangs on them: where those swing, these whip.
#pragma once

#include "core/env/compiled_scenario.h"
#include "core/io/diagnostics.h"

namespace skybody {

/// Warns, once a robot, of joints whose links answer quicker to the weight that hangs on them than
/// fixed steps of this scenario's `dt` can follow.
void warn_of_light_links(const CompiledScenario& compiled, Diagnostics& diagnostics);

}  // namespace skybody
