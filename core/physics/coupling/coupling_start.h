// Couplings at the start that a scenario describes.
#pragma once

#include "core/model/scenario.h"

namespace skybody {

/// Gives couplings without a length the one that the start has.
/// @throws MarkedError where the ends are elsewhere than the coupling can hold them
void fit_couplings(Scenario& scenario);

}  // namespace skybody
