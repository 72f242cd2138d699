#include "bench/limit/check.h"

#include <cstdio>

#include "bench/limit/engine_check.h"

namespace skybody::bench::limit {
namespace {

/// @param bound  of the rows. The hover loop takes the engine's own steps, so that a row differs by
///               rounding to float; payload bodies have other coordinates (their own rotations, not
///               those in the parent), of which a step of Euler's method makes something else, to
///               first order in dt.
bool check_task(const char* name, CheckedTask task, const std::vector<LoopKind>& loops, int repeats,
                double bound) {
  bool good = true;
  const Difference d = compare_with_engine(task, loops.front(), repeats, 300 / repeats);
  std::printf(
      "%s, K=%d, after 300 physics steps from the engine: rows %.1e (of %.1f), reward %.1e\n", name,
      repeats, d.observation, d.moved, d.reward);
  if (!(d.observation < bound && d.reward < bound)) {
    std::printf("%s, K=%d: DOES NOT DO WHAT THE ENGINE DOES\n", name, repeats);
    good = false;
  }
  for (const LoopKind& loop : loops) {
    if (give_same_rows(loops.front(), loop, repeats, 3000 / repeats)) continue;
    std::printf("%s, K=%d: OTHER BITS in %s than %s\n", name, repeats, loop.name,
                loops.front().name);
    good = false;
  }
  return good;
}

}  // namespace

bool check(const Loops& loops) {
  bool good = true;
  for (const int repeats : {1, 10}) {
    good = check_task("hover", CheckedTask::kHover, loops.hover, repeats, 1e-6) && good;
    good = check_task("payload", CheckedTask::kPayload, loops.payload, repeats, 2e-2) && good;
    good = check_task("rod on a pin", CheckedTask::kPinRod, loops.pin_rod, repeats, 1e-5) && good;
  }
  return good;
}

}  // namespace skybody::bench::limit
