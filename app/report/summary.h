// The table at the end of `skybody run`.
#pragma once

#include <string>
#include <vector>

#include "app/report/episode_summary.h"

namespace skybody {

/// One row per episode and goal, and a row for the total.
std::string summary_table(const CompiledScenario& compiled,
                          const std::vector<EpisodeSummary>& episodes);

}  // namespace skybody
