// The check before the measurements.
#pragma once

#include "research/bench/limit/loops.h"

namespace skybody::bench::limit {

/// Prints the differences between the loops and the engine, and between the loops, which must give
/// the same bits. @returns false if something is wrong
bool check(const Loops& loops);

}  // namespace skybody::bench::limit
