// Couplings at the initial state of a scenario.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// Sets missing lengths of couplings to the distance at the initial state.
/// @throws LocatedError if the positions of the ends violate the coupling
void fit_couplings(Scenario& scenario);

/// @throws LocatedError if neither end of a coupling can move: each is driven by a controller or
/// fixed
void check_driven_ends(const World& world);

}  // namespace skybody
