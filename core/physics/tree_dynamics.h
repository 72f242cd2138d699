// `dynamics: tree`: robots as trees of rigid bodies on free or fixed bases (tree_accelerations.h).
#pragma once

#include <memory>
#include <string>

#include "core/physics/dynamics.h"

namespace skybody {

/// Why `dynamics: tree` cannot do a world, as the end of a sentence that begins with "the world";
/// empty if it can. Bodies of one robot do not touch each other; what else could touch is
/// Simbody's.
std::string why_not_tree(const World& world);

/// Drives are read from `world.drives`. Allocates when it is made only; results have the same bits
/// on every processor.
/// @param world  why_not_tree(world) is empty; must outlive the dynamics
/// @throws Error (naming the body) if no rigid body can have the nominal mass properties
std::unique_ptr<Dynamics> make_tree_dynamics(const World& world);

}  // namespace skybody
