// What steps a world: `dynamics` of the scenario.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// What turns forces into accelerations.
enum class DynamicsBackend {
  kTree,     ///< the tree's algorithms
  kSimbody,  ///< Simbody
};

/// `auto` takes the tree's.
inline DynamicsBackend chosen_dynamics(const World& world) {
  return world.scenario.stepping.dynamics == DynamicsChoice::kSimbody ? DynamicsBackend::kSimbody
                                                                      : DynamicsBackend::kTree;
}

}  // namespace skybody
