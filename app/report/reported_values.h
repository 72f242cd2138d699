// Infos of tasks, effects and other plugins in a flight: a battery's charge, success.
#pragma once

#include <string>
#include <vector>

#include "app/report/episode_summary.h"

namespace skybody {

/// A table of the info values over the flight, truncated if long (the log has all); empty if there
/// are none or no step was taken.
std::string reported_values(const CompiledScenario& compiled,
                            const std::vector<EpisodeSummary>& episodes);

}  // namespace skybody
