// Rates of hand-written loops without an engine: the hover and payload environments and one with
// a rod on a pin, scalar and in lanes, for 1 and 10 physics steps per action, 64 to 16,384
// environments, one thread and two spinning ones. Checks first that the loops agree with the
// engine; exit code 1 if they do not.
#include <cstdio>
#include <span>
#include <vector>

#include "app/report/machine.h"
#include "research/bench/limit/check.h"
#include "research/bench/limit/loops.h"
#include "research/bench/limit/rate.h"

namespace skybody::bench::limit {
namespace {

constexpr int kTrials = 40;
constexpr double kSeconds = 0.002;  // of a trial; short ones find quiet moments of the machine
constexpr int kSizes[] = {64, 256, 1024, 4096, 16384};
constexpr int kTeamSizes[] = {32, 128, 512};

/// All loops take turns, so that a slow moment of the machine affects them equally.
/// @returns steps per second of each loop
std::vector<double> best_rates(const std::vector<LoopKind>& loops, int envs, int repeats,
                               int threads) {
  const std::vector<float> actions(static_cast<std::size_t>(envs * loops.front().actions), 0.21f);
  std::vector<EnvironmentArray> arrays;
  for (const LoopKind& loop : loops) arrays.emplace_back(loop, envs, repeats);
  std::vector<double> best(loops.size());
  for (int n = 0; n < kTrials; ++n) {
    for (std::size_t k = 0; k < loops.size(); ++k) {
      best[k] = std::max(best[k], step_rate(arrays[k], actions.data(), threads, kSeconds));
    }
  }
  return best;
}

void measure(const char* task, const std::vector<LoopKind>& loops, int repeats, int threads,
             std::span<const int> sizes = kSizes) {
  std::printf("%s, K=%d, %d thread%s\n", task, repeats, threads, threads > 1 ? "s" : "");
  std::vector<std::vector<double>> columns;
  for (const int envs : sizes) columns.push_back(best_rates(loops, envs, repeats, threads));
  for (std::size_t k = 0; k < loops.size(); ++k) {
    std::printf("  %-16s", loops[k].name);
    for (const std::vector<double>& column : columns) std::printf(" %7.2f", 1e-6 * column[k]);
    std::printf("\n");
  }
}

int run() {
  const Loops loops = all_loops();
  std::printf("without an engine, %s (%s)\n", machine_name().c_str(), processor_name().c_str());
  if (!check(loops)) return 1;
  std::printf("million environment steps/s, best of %d x %.0f ms; environments", kTrials,
              1e3 * kSeconds);
  for (const int envs : kSizes) std::printf(" %d", envs);
  std::printf("\n");
  for (const int threads : {1, 2}) {
    for (const int repeats : {1, 10}) {
      measure("hover", loops.hover, repeats, threads);
      measure("payload", loops.payload, repeats, threads);
      measure("rod on a pin", loops.pin_rod, repeats, threads);
      measure("team of 2, of 32, 128, 512", loops.team_of_2, repeats, threads, kTeamSizes);
      measure("team of 20, of 32, 128, 512", loops.team_of_20, repeats, threads, kTeamSizes);
    }
  }
  return 0;
}

}  // namespace
}  // namespace skybody::bench::limit

int main() { return skybody::bench::limit::run(); }
