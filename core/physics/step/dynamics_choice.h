// What steps a world: `dynamics` of the scenario, and what the world allows.
#pragma once

#include <string>

#include "core/physics/world/world.h"

namespace skybody {

/// What steps a world.
enum class DynamicsUse {
  kTree,      ///< the tree's algorithms, always
  kSimbody,   ///< Simbody, always
  kHandOver,  ///< the tree's where nothing is within reach (reach.h), else Simbody
};

/// Why `dynamics: tree` cannot do a world, as the end of a sentence that begins with "the world";
/// empty if it can: where bodies may touch other robots or obstacles, contact is Simbody's.
std::string why_not_tree(const World& world);

/// `auto` takes tree where that can do the world (why_not_tree), else hands over.
/// @throws MarkedError at `dynamics: tree` if tree cannot do the world (message says why)
DynamicsUse chosen_dynamics(const World& world);

}  // namespace skybody
