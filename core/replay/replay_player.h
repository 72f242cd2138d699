// Runs a recording again and reports whether the results are the same.
#pragma once

#include <memory>

#include "core/assemble/compile_scenario.h"
#include "core/env/compiled_scenario.h"
#include "core/io/files/replay_file.h"
#include "core/replay/replay_report.h"

namespace skybody {

/// Options to load the recorded scenario: its file, or if the file no longer exists the shipped
/// scenario of its name, with the recording's overrides. The recording's plugin path is ignored:
/// the author of a recording must not choose the code that is run.
LoadOptions replay_load_options(const ReplayHeader& header);

/// @throws Error with both hashes and the first difference of the texts if `compiled` is not the
///   recorded scenario
void check_same_scenario(const ReplayReader& replay, const CompiledScenario& compiled);

/// Repeats the recorded calls from the recording's beginning and compares every recorded
/// transition. Reads the recording to its end.
/// @param threads  as PoolOptions::threads; the result does not depend on it
ReplayReport play(ReplayReader& replay, const std::shared_ptr<const CompiledScenario>& compiled,
                  int threads);

}  // namespace skybody
