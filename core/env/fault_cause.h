// The likely cause of a physics step that gave up: its first input that is no finite number, or the
// link or joint that moved fastest; and how an episode's status tells it.
#pragma once

#include <cstdint>
#include <string>

#include "core/env/state_group.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The bits of a status that say so, behind kBadState.
/// @param group  with the lane as it was before the step
std::uint64_t cause_bits(const World& world, const StateGroup& group, int lane);

/// The same in words, such as "link `arm` of robot `quad` turned at 5.8e+04 rad/s before".
/// @param status  @returns empty: the status tells of none
std::string cause_text(const World& world, std::uint64_t status);

}  // namespace skybody
