// Whether the limit loops do what the scenarios do.
#pragma once

#include <string>

#include "bench/limit/loop.h"

namespace skybody::bench::limit {

/// How far a loop and the engine are apart after the same flight.
struct Difference {
  double observation = 0.0;  ///< largest of any value of a row
  double reward = 0.0;
  double moved = 0.0;  ///< for scale: how far values of the row went meanwhile
};

/// What is flown, and how the engine's state becomes the loop's.
enum class CheckedTask { kHover, kPayload, kPinRod, kTeamOf2, kTeamOf20 };

/// Flies the engine and a loop from the same starts with the same random actions about hover for
/// some steps, in the air throughout.
/// @param loop  one by one
Difference compare_with_engine(CheckedTask task, const LoopKind& loop, int repeats, int steps);

/// Whether two loops give the same bits: rows after each of some random steps, with ends and
/// resets.
bool give_same_rows(const LoopKind& a, const LoopKind& b, int repeats, int rounds);

}  // namespace skybody::bench::limit
