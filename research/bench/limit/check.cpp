#include "research/bench/limit/check.h"

#include <cstdio>

#include "research/bench/limit/engine_check.h"

namespace skybody::bench::limit {
namespace {

/// Rows are floats of values up to 7, where floats are 2^-22 apart; in teams up to 30.
constexpr double kBound = 1e-6, kTeamBound = 4e-6;

/// @param steps  physics steps whose rows must be equal in all loops
bool check_task(const char* name, CheckedTask task, const std::vector<LoopKind>& loops, int repeats,
                double bound = kBound, int steps = 3000) {
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
    if (give_same_rows(loops.front(), loop, repeats, steps / repeats)) continue;
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
    good = check_task("hover", CheckedTask::kHover, loops.hover, repeats) && good;
    good = check_task("payload", CheckedTask::kPayload, loops.payload, repeats) && good;
    good = check_task("rod on a pin", CheckedTask::kPinRod, loops.pin_rod, repeats) && good;
    good = check_task("team of 2", CheckedTask::kTeamOf2, loops.team_of_2, repeats, kTeamBound) &&
           good;
    good = check_task("team of 20", CheckedTask::kTeamOf20, loops.team_of_20, repeats, kTeamBound,
                      100) &&
           good;
  }
  return good;
}

}  // namespace skybody::bench::limit
