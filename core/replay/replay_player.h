// Runs a recording again and says whether the same came out.
#pragma once

#include <memory>

#include "core/assemble/load.h"
#include "core/env/compiled_scenario.h"
#include "core/io/replay_file.h"
#include "core/replay/replay_report.h"

namespace skybody {

/// How to load what was recorded: its file, or where that is gone the shipped scenario of its name,
/// with the overrides of the recording. Its plugin path is left out: whoever made the recording
/// does not decide from where code is run.
LoadOptions replay_load_options(const ReplayHeader& header);

/// @throws Error naming both hashes, and where the texts part, if `compiled` is not what was
///         recorded
void check_same_scenario(const ReplayReader& replay, const CompiledScenario& compiled);

/// Does again what was recorded, from the recording's beginning, and compares every transition that
/// it has. Reads the recording to its end.
/// @param threads  as PoolOptions::threads; the outcome does not depend on it
ReplayReport play(ReplayReader& replay, const std::shared_ptr<const CompiledScenario>& compiled,
                  int threads);

}  // namespace skybody
