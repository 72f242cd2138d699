// What steps a world: `dynamics` of the scenario.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// What turns forces into accelerations.
enum class DynamicsUse {
  kTree,     ///< the tree's algorithms
  kSimbody,  ///< Simbody
};

/// `auto` takes the tree's.
inline DynamicsUse chosen_dynamics(const World& world) {
  return world.scenario.stepping.dynamics == DynamicsChoice::kSimbody ? DynamicsUse::kSimbody
                                                                      : DynamicsUse::kTree;
}

}  // namespace skybody
