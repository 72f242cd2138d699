// Rounds of Pool: rate of a step including queue, batches and threads.
#include <benchmark/benchmark.h>

#include "core/assemble/compile_scenario.h"
#include "core/batch/pool.h"

namespace skybody::bench {
namespace {

/// @param state  ranges: environments, batch, threads
void queue(benchmark::State& state, Order order) {
  PoolOptions options;
  options.envs = static_cast<int>(state.range(0));
  options.batch = static_cast<int>(state.range(1));
  options.threads = static_cast<int>(state.range(2));
  options.order = order;
  Pool envs(compile_scenario({"hover", {}, {}}), options);
  const std::vector<float> actions(static_cast<std::size_t>(options.envs) * 4, 0.21f);
  const bool whole = options.batch == options.envs;
  envs.send_reset();
  std::int64_t steps = 0;
  for ([[maybe_unused]] auto _ : state) {
    const auto batch = envs.recv();
    const auto rows = static_cast<std::size_t>(batch->rows);
    if (whole && order == Order::kFixed) {
      envs.send(actions);
    } else {
      envs.send({actions.data(), rows * 4}, {batch->env_id.data(), rows});
    }
    steps += batch->rows;
  }
  state.SetItemsProcessed(steps);
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"envs", "batch", "threads"})->UseRealTime();
  for (const int threads : {1, 2}) {
    benchmark->Args({64, 64, threads})->Args({1024, 1024, threads})->Args({1024, 256, threads});
  }
}
BENCHMARK_CAPTURE(queue, fixed, Order::kFixed)->Apply(sizes);
BENCHMARK_CAPTURE(queue, arrival, Order::kArrival)->Apply(sizes);

}  // namespace
}  // namespace skybody::bench
