// The limit loops.
#pragma once

#include <vector>

#include "research/bench/limit/loop.h"

namespace skybody::bench::limit {

/// Loops by task, the scalar one first.
struct Loops {
  std::vector<LoopKind> hover, payload, pin_rod, team_of_2, team_of_20;
};

/// The loops of one instruction set.
Loops loops_v2();
Loops loops_v3();
Loops loops_v4();

/// All loops that this machine can run.
Loops all_loops();

}  // namespace skybody::bench::limit
