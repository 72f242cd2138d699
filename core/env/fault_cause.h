// The likely cause of a failed physics step: its first input that is not finite, or the link or
// joint that moved fastest. The cause is encoded in the episode's status.
#pragma once

#include <cstdint>
#include <string>

#include "core/env/state_group.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The status bits of the cause, above kBadState.
/// @param group  with the lane in its state before the step
std::uint64_t cause_bits(const World& world, const StateGroup& group, int lane);

/// The cause in words, such as "link `arm` of robot `quad` turned at 5.8e+04 rad/s before".
/// @param status  EpisodeStatus bits
/// @returns empty: the status contains no cause
std::string cause_text(const World& world, std::uint64_t status);

}  // namespace skybody
