// Makes a mission of a policy and its scenario. Part of the engine's side: it is not in the program
// onboard.
#pragma once

#include "core/assemble/compile_scenario.h"
#include "core/io/files/policy_file.h"
#include "onboard/mission.h"

namespace skybody::onboard {

/// @param agent  place among the robots that share the policy; 0 of a policy for one robot
/// @throws InputError as compile_scenario(); Error if the policy does not fit the scenario, sees
///   images, or flies several robots at once
Mission make_mission(LoadOptions options, const PolicyFile& policy, int agent,
                     const Limits& limits);

}  // namespace skybody::onboard
