// Flies references to see whether limits of the laws that follow them cut what they ask for.
#pragma once

#include <memory>

#include "core/io/diagnostics.h"
#include "core/simulation/simulation.h"

namespace skybody {

/// Warns of each reference that a law of the robot's chain follows only within limits of its own,
/// from a flight of 20 s. A scenario without references, or without such laws, is not flown.
void warn_of_limited_references(const std::shared_ptr<const CompiledScenario>& compiled,
                                Diagnostics& diagnostics);

}  // namespace skybody
