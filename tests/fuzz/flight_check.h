// Loads a scenario as `skybody check` does and flies it briefly.
#pragma once

#include <span>
#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/io/yaml/diagnostics.h"
#include "core/simulation/simulation.h"
#include "tests/fuzz/area.h"

namespace skybody::fuzz {

/// Loads and flies.
/// @param thorough  does everything twice; both results must be equal
/// @throws Finding if a refusal has no one-line message with a location, or if an accepted scenario
///         gives rows that are not finite
Answer check_flight(const LoadOptions& options, bool thorough);

/// @throws Finding if the message is not one printable line
void check_message(const std::string& message);

/// The messages of a refusal.
/// @throws Finding if no message is an error with a location, or a message is not one printable
///         line
std::string check_refusal(const Diagnostics& diagnostics);

/// Allowed values of rows with a fault. A fault returns the last finite observation; a hand-made
/// state may have none.
enum class Faults { kAreFinite, kAreAnything };

/// Info values of a fault come from the task, evaluated on an invalid state.
/// @throws Finding if a value of the last transition is not finite
void check_rows(const Simulation& simulation, Faults faults = Faults::kAreFinite);

/// @throws Finding if a value is not finite
void check_finite(const char* what, std::span<const float> values);

}  // namespace skybody::fuzz
