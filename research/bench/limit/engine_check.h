// Checks that the limit loops agree with the scenarios.
#pragma once

#include <string>

#include "research/bench/limit/loop.h"

namespace skybody::bench::limit {

/// Difference between a loop and the engine after the same flight.
struct Difference {
  double observation = 0.0;  ///< largest of all values of a row
  double reward = 0.0;
  double moved = 0.0;  ///< for scale: the largest change of the row's values in the flight
};

/// The task, and the mapping from the engine's state to the loop's.
enum class CheckedTask { kHover, kPayload, kPinRod, kTeamOf2, kTeamOf20 };

/// Flies the engine and a loop from the same initial states with the same random actions near hover
/// for some steps, without ground contact.
/// @param loop  a scalar loop
Difference compare_with_engine(CheckedTask task, const LoopKind& loop, int repeats, int steps);

/// Whether two loops give the same bits: rows after each of some random steps, with ends and
/// resets.
bool give_same_rows(const LoopKind& a, const LoopKind& b, int repeats, int rounds);

}  // namespace skybody::bench::limit
