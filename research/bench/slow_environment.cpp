// Cost of one slow environment among 64 for the others, by order of batches.
//
// A step of a quadrotor on Simbody takes some microseconds; environment 0 takes 100 times as long,
// either computing or waiting. If it computes, it occupies a thread: of T threads T-1 are left, so
// no scheduler keeps more than (T-1)/T of the rate. If it waits, it costs a thread, but no
// processor.
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/batch/pool.h"

namespace skybody::bench {
namespace {

constexpr int kEnvs = 64;
constexpr int kBatch = kEnvs / 3;
constexpr int kTrials = 5;
constexpr double kSeconds = 0.5;
constexpr double kTurn = 4e-9;  // of the slow controller's division chain, approximately [s]

using Clock = std::chrono::steady_clock;

struct Case {
  const char* what;
  double turns, sleep;
  int env = 0;  ///< the slow one, -1: all
};

std::shared_ptr<const CompiledScenario> load(const Case& c) {
  const std::string slow = "{plugin: slow_controller, parameters: {env: " + std::to_string(c.env) +
                           ", turns: " + std::to_string(c.turns) +
                           ", sleep: " + std::to_string(c.sleep) + "}}";
  return compile_scenario(
      {"hover",
       {"stepping.dynamics=simbody",
        "robots.quad.controllers=[{plugin: rotor_speed, name: motors, parameters: "
        "{max_speed: 2300}}, " +
            slow + "]"},
       {SKYBODY_BENCH_PLUGINS}});
}

/// Steps per second; every received environment is sent again at once.
double rate(const std::shared_ptr<const CompiledScenario>& compiled, int envs_count, int threads,
            Order order) {
  PoolOptions options;
  options.envs = envs_count;
  options.batch = envs_count == kEnvs ? kBatch : envs_count;
  options.threads = threads;
  options.order = order;
  Pool envs(compiled, options);
  const auto width = static_cast<std::size_t>(compiled->action_size());
  const std::vector<float> actions(kEnvs * width, 0.2f);
  envs.send_reset();
  long steps = 0;
  const Clock::time_point start = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  while (elapsed() < kSeconds) {
    const auto batch = envs.recv();
    const auto rows = static_cast<std::size_t>(batch->rows);
    envs.send({actions.data(), rows * width}, {batch->env_id.data(), rows});
    steps += batch->rows;
  }
  return static_cast<double>(steps) / elapsed();
}

double best_rate(const Case& c, int threads, Order order, int envs = kEnvs) {
  const auto compiled = load(c);
  double best = 0.0;
  for (int k = 0; k < kTrials; ++k) best = std::max(best, rate(compiled, envs, threads, order));
  return best;
}

/// Four slow environments: two threads have two each.
void four_slow(double step) {
  const Case slow{"", 100.0 * step / kTurn, 0, -1};
  const double one = best_rate(slow, 1, Order::kFixed, 4);
  const double two = best_rate(slow, 2, Order::kFixed, 4);
  std::printf("  four slow environments, all of them a batch: 2 threads take %.2f times 1's rate\n",
              two / one);
}

int run() {
  std::printf("64 environments, batches of %d, one of them 100 times slower; best of %d x %.1f s\n",
              kBatch, kTrials, kSeconds);
  std::printf("  %-34s %10s %10s %10s %12s\n", "", "steps/s", "of none", "fixed", "can be kept");
  for (const int threads : {2, 3}) {
    const double step = 2.0 / best_rate({"", 0, 0}, 2, Order::kArrival);  // of one thread [s]
    const Case cases[] = {
        {"none", 0, 0}, {"one computes", 100.0 * step / kTurn, 0}, {"one waits", 0, 100.0 * step}};
    double none = 0.0;
    for (const Case& c : cases) {
      const double arrival = best_rate(c, threads, Order::kArrival);
      if (none == 0.0) none = arrival;
      const double fixed = best_rate(c, threads, Order::kFixed);
      const char* bound = c.turns > 0.0 ? (threads == 2 ? "1/2" : "2/3 (*)") : "1";
      std::printf("  %d threads, %-23s %10.0f %9.0f%% %9.0f%% %12s\n", threads, c.what, arrival,
                  100.0 * arrival / none, 100.0 * fixed / none, bound);
    }
  }
  four_slow(2.0 / best_rate({"", 0, 0}, 2, Order::kArrival));
  std::printf("  (*) with three processors; on two the system shares them among the threads\n");
  return 0;
}

}  // namespace
}  // namespace skybody::bench

int main() { return skybody::bench::run(); }
