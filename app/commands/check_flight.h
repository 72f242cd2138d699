// The trial flight of `skybody check`.
#pragma once

#include <memory>

#include "core/env/compiled_scenario.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Resets the environment and takes a few steps with idle and with random actions. Warnings:
///   - robots that begin inside another shape;
///   - robots that must hover but cannot carry their weight.
/// Errors:
///   - every draw gives bodies that are not physical;
///   - the task reports a failure at every start;
///   - every goal is below the ground.
/// @param compiled  in checked mode
/// @throws LocatedError if a plugin accesses values out of its range
void fly_for_a_moment(const std::shared_ptr<const CompiledScenario>& compiled,
                      Diagnostics& diagnostics);

}  // namespace skybody
