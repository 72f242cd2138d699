// What `skybody check` learns by flying a scenario for a moment.
#pragma once

#include <memory>

#include "core/env/compiled_scenario.h"
#include "core/io/diagnostics.h"

namespace skybody {

/// Resets the environment and takes a few steps with idle and with random actions; warns of robots
/// that begin inside something and of those that cannot carry their weight though they are to
/// hover. Draws that give nothing but bodies that cannot be are an error, and so are starts of
/// which the task sees each as a failure, and goals below the ground.
/// @param compiled  in checked mode
/// @throws LocatedError where a plugin touches values beyond those that it may
void fly_for_a_moment(const std::shared_ptr<const CompiledScenario>& compiled,
                      Diagnostics& diagnostics);

}  // namespace skybody
