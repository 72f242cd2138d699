// Detects joints whose dampers, springs or drives are too stiff for a fixed step.
#pragma once

#include "core/env/compiled_scenario.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Warns, once per robot, if joint forces respond faster than fixed steps of this scenario's `dt`
/// can follow. Uses nominal constants and the joint positions of a reset.
void warn_of_stiff_joints(const CompiledScenario& compiled, Diagnostics& diagnostics);

}  // namespace skybody
