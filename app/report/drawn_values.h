// Randomizable values that differed from nominal, over the episodes of a flight.
#pragma once

#include <string>
#include <vector>

#include "app/report/episode_summary.h"

namespace skybody {

/// A table of the drawn values, truncated if long (the log has all); empty if none was drawn.
std::string drawn_values(const CompiledScenario& compiled,
                         const std::vector<EpisodeSummary>& episodes);

}  // namespace skybody
