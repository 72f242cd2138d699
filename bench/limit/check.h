// The check that measurements begin with.
#pragma once

#include "bench/limit/loops.h"

namespace skybody::bench::limit {

/// Prints how far the loops are from the engine, and from one another: they must give the same
/// bits. @returns false if something is wrong
bool check(const Loops& loops);

}  // namespace skybody::bench::limit
