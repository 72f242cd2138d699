// Flies references to detect tracking controllers that are limited by their own bounds.
#pragma once

#include <memory>

#include "core/io/yaml/diagnostics.h"
#include "core/simulation/simulation.h"

namespace skybody {

/// Warns of each reference that saturates the limits of a controller in the robot's chain, from a
/// flight of 20 s. Skipped for a scenario without references or without such controllers.
void warn_of_limited_references(const std::shared_ptr<const CompiledScenario>& compiled,
                                Diagnostics& diagnostics);

}  // namespace skybody
