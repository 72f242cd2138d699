// The one-by-one path of robots that are one free body each.
#pragma once

#include <memory>

#include "core/physics/stepper.h"

namespace skybody {

/// A stepper with the bits of the kernels on packs.
/// @param world  FreeRobots::is_possible
/// @param use    kTree, or kHandOver: then Simbody takes the steps where something is within reach
std::unique_ptr<Stepper> make_free_stepper(const World& world, DynamicsUse use);

}  // namespace skybody
