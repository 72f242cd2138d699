// Resets: items are environments, times are of a group.
#include <benchmark/benchmark.h>

#include "research/bench/bare_simbody.h"
#include "research/bench/micro/group.h"

namespace skybody::bench {
namespace {

const std::string kDrawn =
    "randomization=[{plugin: vehicle_constants, name: inertia, parameters: {robot: quad, mass: "
    "[0.9, 1.1], inertia: [0.9, "
    "1.1], thrust_constant: [0.9, 1.1], moment_constant: [0.9, 1.1], tau_up: [0.9, 1.1], tau_down: "
    "[0.9, 1.1]}}, {plugin: start, parameters: {robot: quad, position_min: [-5, -5, 0.3], "
    "position_max: [5, 5, 3], yaw_min: -0.72, yaw_max: 0.72}}]";

/// A reset and the step after it, which completes the deferred work of the reset.
void reset(benchmark::State& state, const std::vector<std::string>& overrides) {
  Group group("hover", overrides);
  for ([[maybe_unused]] auto _ : state) {
    group.reset();
    group.step();
  }
  state.SetItemsProcessed(state.iterations() * group.lanes_of());
}
BENCHMARK_CAPTURE(reset, start_drawn, std::vector<std::string>{});
BENCHMARK_CAPTURE(reset, constants_drawn, std::vector<std::string>{kDrawn});
BENCHMARK_CAPTURE(reset, constants_drawn_simbody,
                  std::vector<std::string>{kDrawn, "stepping.dynamics=simbody"});

/// Hand-written change of the mass: a new topology.
void bare_rebuild(benchmark::State& state) {
  const auto world = make_bare_loop(true);
  double scale = 0.9;
  for ([[maybe_unused]] auto _ : state) {
    world->rebuild(scale);
    scale = scale > 1.1 ? 0.9 : scale + 0.01;
  }
}
BENCHMARK(bare_rebuild);

}  // namespace
}  // namespace skybody::bench
