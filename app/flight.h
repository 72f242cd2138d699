// Flies episodes: policy, simulation and log step by step.
#pragma once

#include <cstdint>
#include <vector>

#include "app/report/episode_summary.h"
#include "core/io/files/flight_log.h"
#include "core/policy/policy.h"
#include "core/simulation/simulation.h"

namespace skybody {

struct RolloutPlan {
  std::uint64_t episodes = 1;
  std::uint64_t most_steps = 0;  ///< per episode, unless task or horizon end it earlier
};

/// Flies the plan until its end, or a signal if there is an InterruptGuard, and writes every state
/// to `log`, which stays open.
std::vector<EpisodeSummary> fly(const RolloutPlan& plan, Simulation& simulation, Policy& policy,
                                FlightLog& log);

}  // namespace skybody
