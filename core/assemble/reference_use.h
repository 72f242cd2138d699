// A reference in place of a policy: `skybody run SCENARIO --reference NAME[:key=value,...]`.
#pragma once

#include <string>

#include "core/env/compiled_scenario.h"
#include "core/io/scenario_reader.h"

namespace skybody {

/// The change of a scenario by which a reference flies it. It puts the controller `reference`, and
/// the controllers that lead from it to the robot's chain, before that chain, and puts the task
/// `watch` in the place of the scenario's own: without a policy there is nothing to reward, and no
/// goal or horizon that would end a flight.
/// @param text      the name of a shipped reference, or a YAML file with parameters of `reference`;
///                  behind a colon parameters that replace those: `circle:peak_speed=2,centre=[0,
///                  0, 1.5]`. The key `robot` names the robot; else it is the only one with rotors
///                  or the first of them.
/// @param compiled  the scenario as it is
/// @returns nothing and errors where the reference or the way to the chain is missing
ScenarioEdit reference_edit(const std::string& text, const CompiledScenario& compiled,
                            Diagnostics& diagnostics);

}  // namespace skybody
