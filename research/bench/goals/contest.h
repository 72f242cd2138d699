// A scenario in Pool against its limit loops, in turns.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "research/bench/limit/loop.h"

namespace skybody::bench {

/// Duration of measurements: each contestant's best of `trials` x `seconds`. All take turns, so
/// that a slow moment of the machine affects all and each one gets a quiet moment.
struct Effort {
  int trials = 40;
  double seconds = 0.004;
};

/// One comparison.
struct Contest {
  LoadOptions scenario;
  std::string actions = "hold";        ///< of BatchActions, or a name for `constant`
  std::optional<float> constant = {};  ///< value of all actions, in place of that stream
  /// Actions of the limit if they differ: with rotors at rest its vehicles would fall.
  std::string limit_actions = {};
  std::vector<limit::LoopKind> loops;  ///< the loops in lanes; the best counts
  int envs = 1024;
  int repeats = 1;  ///< K
  int threads = 1;
  double settle = 0.0;  ///< physics time before the measurement [s], for vehicles to come to rest
};

/// Environment steps per second.
struct Outcome {
  double ours = 0.0, limit = 0.0;
  std::string loop;         ///< name of the best loop
  double near_share = 0.0;  ///< share of our physics steps with bodies near contact
};

Outcome run_contest(const Contest& contest, const Effort& effort);

/// Steps per second of the scenario only.
double engine_rate(const Contest& contest, const Effort& effort);

}  // namespace skybody::bench
