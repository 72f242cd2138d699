// The limit loops.
#pragma once

#include <vector>

#include "bench/limit/loop.h"

namespace skybody::bench::limit {

/// By task, one by one first.
struct Loops {
  std::vector<LoopKind> hover, payload, pin_rod, team_of_2, team_of_20;
};

/// Those of one instruction set.
Loops loops_v2();
Loops loops_v3();
Loops loops_v4();

/// Every loop that this machine can run.
Loops all_loops();

}  // namespace skybody::bench::limit
