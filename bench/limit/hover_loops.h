// The loops of the hover limit.
#pragma once

#include <vector>

#include "bench/limit/loop.h"

namespace skybody::bench::limit {

/// Those of one instruction set, one by one first.
std::vector<LoopKind> hover_loops_v2();
std::vector<LoopKind> hover_loops_v3();
std::vector<LoopKind> hover_loops_v4();

/// Every loop that this machine can run: one by one first.
std::vector<LoopKind> hover_loops();

}  // namespace skybody::bench::limit
