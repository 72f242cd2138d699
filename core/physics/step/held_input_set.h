// Which held inputs a step kernel is compiled for.
#pragma once

#include "core/model/held_inputs.h"
#include "core/physics/world/world.h"

namespace skybody {

enum class HeldInputSet {
  kNothing,
  kAir,      ///< of a plain quadrotor, by the midpoint rule: what may_hold() names
  kAnything  ///< of any world
};

/// Whether a world of this kind may have something that holds the input. Air is what most flights
/// have: wind, drag of the body and a battery.
constexpr bool may_hold(HeldInputSet kind, int input) {
  if (kind != HeldInputSet::kAir) return kind == HeldInputSet::kAnything;
  return input == SKYBODY_HELD_WIND || input == SKYBODY_HELD_BODY_DRAG ||
         input == SKYBODY_HELD_ROTOR_LIMIT;
}

/// @param is_plain  FreeRobot::is_plain_quadrotor of the world's only robot
HeldInputSet held_input_set(const World& world, bool is_plain);

}  // namespace skybody
