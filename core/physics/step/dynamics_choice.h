// Choice of the dynamics of a world: `dynamics` of the scenario.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// Backend that computes accelerations from forces.
enum class DynamicsBackend {
  kTree,     ///< the tree's algorithms
  kSimbody,  ///< Simbody
};

/// `auto` selects the tree's algorithms.
inline DynamicsBackend chosen_dynamics(const World& world) {
  return world.scenario.stepping.dynamics == DynamicsChoice::kSimbody ? DynamicsBackend::kSimbody
                                                                      : DynamicsBackend::kTree;
}

}  // namespace skybody
