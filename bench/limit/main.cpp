// What a hand-written loop without an engine does: the hover environment one by one and in lanes,
// for 1 and 10 physics steps an action, 64 to 16,384 environments, one thread and two spinning
// ones. Checks first that the loops do what the engine does; exit code 1 if they do not.
#include <cstdio>
#include <vector>

#include "app/machine.h"
#include "bench/limit/hover_check.h"
#include "bench/limit/hover_loops.h"
#include "bench/limit/rate.h"

namespace skybody::bench::limit {
namespace {

constexpr int kTrials = 15;
constexpr double kSeconds = 0.01;  // a trial; short ones find quiet moments of the machine
constexpr float kHold = 2.0f * 1391.0f / 2300.0f - 1.0f;

/// Prints how far the loops are from the engine and from one another.
bool check(const std::vector<LoopKind>& loops) {
  bool good = true;
  for (const int repeats : {1, 10}) {
    const HoverDifference d = compare_with_engine(loops.front(), repeats, 1000 / repeats);
    std::printf(
        "after 1000 physics steps, K=%d, from the engine: state %.1e, rows %.1e, reward %.1e\n",
        repeats, d.state, d.observation, d.reward);
    good = good && d.state < 1e-9 && d.observation < 1e-5 && d.reward < 1e-6;
    for (const LoopKind& loop : loops) {
      if (give_same_rows(loops.front(), loop, repeats, 5000)) continue;
      std::printf("%s: other bits than %s\n", loop.name, loops.front().name);
      good = false;
    }
  }
  std::printf(good ? "all loops give the same bits\n" : "THE LIMIT IS WRONG\n");
  return good;
}

double best_rate(const LoopKind& loop, int envs, int repeats, int threads) {
  EnvironmentArray array(loop, envs, repeats);
  const std::vector<float> actions(static_cast<std::size_t>(envs) * 4, kHold);
  double best = 0.0;
  for (int k = 0; k < kTrials; ++k) {
    best = std::max(best, step_rate(array, actions.data(), threads, kSeconds));
  }
  return best;
}

int run() {
  const std::vector<LoopKind> loops = hover_loops();
  std::printf("hover without an engine, %s (%s)\n", machine_name().c_str(),
              processor_name().c_str());
  if (!check(loops)) return 1;
  std::printf("million environment steps/s, best of %d x %.0f ms\n", kTrials, 1e3 * kSeconds);
  for (const int repeats : {1, 10}) {
    std::printf("K=%-18d", repeats);
    for (const int envs : {64, 256, 1024, 4096, 16384}) std::printf(" %7d", envs);
    std::printf("\n");
    for (const int threads : {1, 2}) {
      for (const LoopKind& loop : loops) {
        std::printf("%-16s x%d ", loop.name, threads);
        for (const int envs : {64, 256, 1024, 4096, 16384}) {
          std::printf(" %7.2f", 1e-6 * best_rate(loop, envs, repeats, threads));
        }
        std::printf("\n");
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace skybody::bench::limit

int main() { return skybody::bench::limit::run(); }
