// The held inputs for which a step kernel is compiled.
#pragma once

#include "core/model/held_inputs.h"
#include "core/physics/world/world.h"

namespace skybody {

enum class HeldInputSet {
  kNothing,
  kAir,      ///< inputs of may_hold(), of a plain quadrotor with the midpoint rule
  kAnything  ///< any inputs, of any world
};

/// Whether worlds of this kind may hold an input. kAir covers the most common inputs: wind, drag of
/// the body and a battery.
constexpr bool may_hold(HeldInputSet kind, int input) {
  if (kind != HeldInputSet::kAir) return kind == HeldInputSet::kAnything;
  return input == SKYBODY_HELD_WIND || input == SKYBODY_HELD_BODY_DRAG ||
         input == SKYBODY_HELD_ROTOR_LIMIT;
}

/// @param is_plain  FreeRobot::is_plain_quadrotor of the world's only robot
HeldInputSet held_input_set(const World& world, bool is_plain);

}  // namespace skybody
