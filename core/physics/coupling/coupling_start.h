// Couplings at the start that a scenario describes.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// Gives couplings without a length the one that the start has.
/// @throws LocatedError where the ends are elsewhere than the coupling can hold them
void fit_couplings(Scenario& scenario);

/// @throws LocatedError where neither end of a coupling can give way, of two that are driven by
///         controllers, or one that is and one that stands still
void check_driven_ends(const World& world);

}  // namespace skybody
