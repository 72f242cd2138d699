// Joints whose dampers, springs or drives are too stiff for a fixed step.
#pragma once

#include "core/env/compiled_scenario.h"
#include "core/io/diagnostics.h"

namespace skybody {

/// Warns, once a robot, where the forces in its joints answer quicker than fixed steps of this
/// scenario's `dt` can follow: by nominal constants, with the joints as at a reset.
void warn_of_stiff_joints(const CompiledScenario& compiled, Diagnostics& diagnostics);

}  // namespace skybody
