// The one-by-one path of robots that are one free body each.
#pragma once

#include <memory>

#include "core/physics/stepper.h"

namespace skybody {

/// A stepper with the bits of the kernels on packs.
/// @param world  FreeRobots::is_possible
std::unique_ptr<Stepper> make_free_stepper(const World& world);

}  // namespace skybody
