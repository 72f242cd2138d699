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

struct FlightResult {
  std::vector<EpisodeSummary> episodes;
  int signal = 0;  ///< signal that stopped the flight; 0: none
};

/// Flies the plan until its end or a signal, and writes every state to `log`, which stays open.
FlightResult fly(const RolloutPlan& plan, Simulation& simulation, Policy& policy, FlightLog& log);

}  // namespace skybody
