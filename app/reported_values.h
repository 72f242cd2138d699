// What tasks, effects and other plugins reported in a flight: a battery's charge, success.
#pragma once

#include <string>
#include <vector>

#include "app/episode_summary.h"

namespace skybody {

/// A table of the info values over the flight, its longer part left to the log; empty if there are
/// none or nothing was flown.
std::string reported_values(const CompiledScenario& compiled,
                            const std::vector<EpisodeSummary>& episodes);

}  // namespace skybody
