// Which randomizable values differed from nominal, over the episodes of a flight.
#pragma once

#include <string>
#include <vector>

#include "app/episode_summary.h"

namespace skybody {

/// A table of what was drawn, its longer part left to the log; empty if nothing was.
std::string drawn_values(const CompiledScenario& compiled,
                         const std::vector<EpisodeSummary>& episodes);

}  // namespace skybody
