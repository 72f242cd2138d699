// Flying some episodes: policy, simulation and log step by step.
#pragma once

#include <cstdint>
#include <vector>

#include "app/episode_summary.h"
#include "core/io/flight_log.h"
#include "core/policy/policy.h"
#include "core/simulation/simulation.h"

namespace skybody {

struct RolloutPlan {
  std::uint64_t episodes = 1;
  std::uint64_t most_steps = 0;  ///< an episode, when neither task nor horizon ends it before
};

struct FlightResult {
  std::vector<EpisodeSummary> episodes;
  int signal = 0;  ///< that stopped the flight; 0: none
};

/// Flies the plan, or until a signal comes, and writes every state to `log`, which stays open.
FlightResult fly(const RolloutPlan& plan, Simulation& simulation, Policy& policy, FlightLog& log);

}  // namespace skybody
