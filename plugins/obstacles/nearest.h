// The few nearest of many candidates, without branches: every lane has its own order.
#pragma once

#include <skybody/plugin.h>

namespace skybody::obstacles {

/// Inserts `next` into the sorted list of the nearest. Farther entries move one place on, and the
/// last one drops out. Between equal distances the earlier one stays first.
/// @tparam Seen  has a `distance`, and choose(mask, a, b) for lane-wise selection
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
