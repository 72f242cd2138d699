// Places every block of state words of a scenario whose plugins are configured.
#pragma once

#include "core/env/scenario_model.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Sets the places of plugins' words, the observation, the infos and the world.
/// @param model     with its plugins, chains and actions
/// @param topology  of the world that is made
/// @param plan      with the parameters, sites and drives that configured plugins asked for
/// @throws LocatedError if `observe` or `infos` of the scenario names no value, or one twice
void lay_out_scenario(ScenarioModel& model, const Topology& topology, WorldPlan plan);

}  // namespace skybody
