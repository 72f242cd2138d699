// Reads `couplings` of a scenario: connections between robots, bodies and the world.
#pragma once

#include <optional>
#include <vector>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/scenario.h"

namespace skybody {

/// Reads one entry of `couplings`; errors go to `diagnostics`.
/// @param robots  the robots that it may connect
std::optional<Coupling> read_coupling(const ConfigNode& node, const std::vector<RobotUse>& robots,
                                      Diagnostics& diagnostics);

}  // namespace skybody
