// Converts an environment's names and values for the flight log.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/files/flight_log.h"
#include "core/simulation/simulation.h"

namespace skybody {

/// `robot.body` for a body in the world's numbering.
std::string body_name(const CompiledScenario& compiled, int body);

/// Data of the log that is constant over the flight.
FlightLogHeader describe_flight(const CompiledScenario& compiled, std::uint64_t seed,
                                const std::string& policy);

/// Appends the simulation's current state to the log's episode.
void record(const Simulation& simulation, FlightLog& log);

}  // namespace skybody
