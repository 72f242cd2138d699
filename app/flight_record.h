// An environment's names and values as the flight log takes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/flight_log.h"
#include "core/simulation/simulation.h"

namespace skybody {

/// `robot.body` of a body in the world's numbering.
std::string body_name(const CompiledScenario& compiled, int body);

/// What holds for the whole flight.
FlightLogHeader describe_flight(const CompiledScenario& compiled, std::uint64_t seed,
                                const std::string& policy);

/// Appends the simulation's present state to the log's episode.
void record(const Simulation& simulation, FlightLog& log);

}  // namespace skybody
