// The nearest few of many, without a branch: every lane has its own order.
#pragma once

#include <skybody/plugin.h>

namespace skybody::obstacles {

/// Puts `next` among the nearest, in order; what is farther goes one place on, and the last drops
/// out. Of two that are as near as one another the first that came stays before.
/// @tparam Seen  has a `distance`, and choose(mask, a, b) takes it apart
/// @param nearest  of `count` places
template <class Seen>
SKYBODY_INLINE void put_in_order(Seen next, Seen* nearest, int count) {
  for (int k = 0; k < count; ++k) {
    const auto nearer = next.distance < nearest[k].distance;
    const Seen passed = choose(nearer, nearest[k], next);
    nearest[k] = choose(nearer, next, nearest[k]);
    next = passed;
  }
}

}  // namespace skybody::obstacles
