// A scenario through Pool against its limit loops, in turns.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/limit/loop.h"
#include "core/assemble/load.h"

namespace skybody::bench {

/// How long measurements take: each contestant's best of `trials` x `seconds`, all taking turns, so
/// that a slow moment of the machine hits all and a quiet one is found by each.
struct Effort {
  int trials = 40;
  double seconds = 0.004;
};

/// One comparison.
struct Contest {
  LoadOptions scenario;
  std::string actions = "hold";        ///< of the engine's BatchActions, or a name for `constant`
  std::optional<float> constant = {};  ///< of all actions, in place of those of that name
  /// Of the limit where they differ: at rest on the ground its vehicles would fall.
  std::string limit_actions = {};
  std::vector<limit::LoopKind> loops;  ///< those in lanes; the best counts
  int envs = 1024;
  int repeats = 1;  ///< K
  int threads = 1;
  double settle = 0.0;  ///< physics time before the measurement [s], for what has to come to rest
};

/// Environment steps a second.
struct Outcome {
  double ours = 0.0, limit = 0.0;
  std::string loop;         ///< the best
  double near_share = 0.0;  ///< share of our physics steps with something near enough to touch
};

Outcome run_contest(const Contest& contest, const Effort& effort);

/// Steps a second of the scenario alone.
double engine_rate(const Contest& contest, const Effort& effort);

}  // namespace skybody::bench
