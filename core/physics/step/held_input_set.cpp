#include "core/physics/step/held_input_set.h"

namespace skybody {

HeldInputSet held_input_set(const World& world, bool is_plain) {
  bool is_any = false;
  bool is_air = is_plain && world.scenario.stepping.integrator == IntegratorChoice::kMidpoint;
  for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
    if (world.layout.held[static_cast<std::size_t>(i)].size == 0) continue;
    is_any = true;
    is_air &= may_hold(HeldInputSet::kAir, i);
  }
  return !is_any ? HeldInputSet::kNothing : is_air ? HeldInputSet::kAir : HeldInputSet::kAnything;
}

}  // namespace skybody
