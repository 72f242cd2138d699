// A reference in place of a policy: `skybody run SCENARIO --reference NAME[:key=value,...]`.
#pragma once

#include <string>

#include "core/env/compiled_scenario.h"
#include "core/io/yaml/scenario_reader.h"

namespace skybody {

/// The edit of a scenario that lets a reference command it:
/// - inserts the controller `reference`, and the controllers from its output to the robot's chain,
///   before that chain
/// - replaces the scenario's task by `watch`: without a policy there is no reward, and no goal or
///   horizon ends the flight
/// @param text      the name of a shipped reference, or a YAML file with parameters of `reference`;
///                  after a colon, parameters that replace those: `circle:peak_speed=2,centre=[0,
///                  0, 1.5]`. The key `robot` selects the robot; by default it is the only one
///                  with such a chain.
/// @param compiled  the scenario before the edit
/// @returns an empty edit, with errors, if the reference or controllers to the chain are missing
ScenarioEdit reference_edit(const std::string& text, const CompiledScenario& compiled,
                            Diagnostics& diagnostics);

}  // namespace skybody
