// `couplings` of a scenario: what joins robots, bodies and the world.
#pragma once

#include <optional>
#include <vector>

#include "core/io/config_tree.h"
#include "core/io/diagnostics.h"
#include "core/model/scenario.h"

namespace skybody {

/// One entry of `couplings`; what is wrong with it goes to `diagnostics`.
/// @param robots  that it may join
std::optional<Coupling> read_coupling(const ConfigNode& node, const std::vector<RobotUse>& robots,
                                      Diagnostics& diagnostics);

}  // namespace skybody
