// `dynamics: tree`: robots as trees of rigid bodies on free or fixed bases (tree_accelerations.h).
#pragma once

#include <memory>
#include <string>

#include "core/physics/dynamics.h"

namespace skybody {

/// Why `dynamics: tree` cannot do a world, as the end of a sentence that begins with "the world";
/// empty if it can: where bodies may touch other robots or obstacles, contact is Simbody's.
std::string why_not_tree(const World& world);

/// Any world, without contact of bodies with one another and with obstacles: right wherever none is
/// within reach (reach.h). Drives are read from `world.drives`. Allocates when it is made only;
/// results have the same bits on every processor.
/// @param world  must outlive the dynamics
/// @throws Error (naming the body) if no rigid body can have the nominal mass properties
std::unique_ptr<Dynamics> make_tree_dynamics(const World& world);

}  // namespace skybody
