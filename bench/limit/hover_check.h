// Whether the hover limit does what the hover scenario does.
#pragma once

#include "bench/limit/loop.h"

namespace skybody::bench::limit {

/// How far a loop and the engine are apart after the same flight.
struct HoverDifference {
  double state = 0.0;  ///< largest of any coordinate, velocity (SI) or rotor speed [100 rad/s]
  double observation = 0.0;  ///< largest of any value of a row
  double reward = 0.0;
};

/// Flies both from the same starts with the same random actions about hover for some steps, in the
/// air throughout.
HoverDifference compare_with_engine(const LoopKind& loop, int repeats, int steps);

/// Whether two loops give the same bits: rows after `rounds` random steps, with ends and resets.
bool give_same_rows(const LoopKind& a, const LoopKind& b, int repeats, int rounds);

}  // namespace skybody::bench::limit
