// Steps per second of a limit loop.
#pragma once

#include <chrono>
#include <functional>

#include "research/bench/limit/array.h"
#include "research/bench/limit/spinning_pair.h"

namespace skybody::bench::limit {

/// Repeats `round` for about `seconds`. @returns rounds per second
inline double rounds_per_second(const std::function<void()>& round, double seconds) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  double time = 0.0;
  long rounds = 0;
  for (long chunk = 1; time < seconds; chunk = time < 0.01 * seconds ? 2 * chunk : chunk) {
    for (long k = 0; k < chunk; ++k) round();
    rounds += chunk;
    time = std::chrono::duration<double>(Clock::now() - start).count();
  }
  return static_cast<double>(rounds) / time;
}

/// @param actions  [N, 4], the same every round
/// @param threads  1 or 2
/// @returns environment steps per second
inline double step_rate(EnvironmentArray& array, const float* actions, int threads,
                        double seconds) {
  if (threads == 1) {
    return array.envs() * rounds_per_second([&] { array.step(actions); }, seconds);
  }
  SpinningPair pair([&](int share) { array.step(actions, share, 2); });
  return array.envs() * rounds_per_second([&] { pair.run(); }, seconds);
}

}  // namespace skybody::bench::limit
