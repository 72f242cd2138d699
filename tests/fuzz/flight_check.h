// Loads a scenario as `skybody check` does and flies it for a moment.
#pragma once

#include <span>
#include <string>

#include "core/assemble/load.h"
#include "core/io/diagnostics.h"
#include "core/simulation/simulation.h"
#include "tests/fuzz/area.h"

namespace skybody::fuzz {

/// Loads and flies.
/// @param thorough  does everything twice; both must be the same
/// @throws Finding if it is refused without a message that names a place and reads as one line, or
///         accepted and rows are not finite
Answer check_flight(const LoadOptions& options, bool thorough);

/// @throws Finding if the message would not be one readable line
void check_message(const std::string& message);

/// The messages of a refusal.
/// @throws Finding if none is an error that names a place, or one is no readable line
std::string check_refusal(const Diagnostics& diagnostics);

/// What rows with a fault may hold: a fault gives the last finite observation, which a state that
/// somebody made up need not have.
enum class Faults { kAreFinite, kAreAnything };

/// Info values of a fault are what the task says of a state that is none.
/// @throws Finding if a value of the last transition is not finite
void check_rows(const Simulation& simulation, Faults faults = Faults::kAreFinite);

/// @throws Finding if a value is not finite
void check_finite(const char* what, std::span<const float> values);

}  // namespace skybody::fuzz
