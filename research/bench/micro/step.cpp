// A step and its parts, on one thread: times are per environment.
#include <benchmark/benchmark.h>

#include "research/bench/micro/group.h"

namespace skybody::bench {
namespace {

/// Runs a function on a group; the counter is environments per second.
template <class What>
void run(benchmark::State& state, Group& group, What&& what) {
  long step = 0;
  for ([[maybe_unused]] auto _ : state) {
    group.keep_flying(++step);
    what(group);
  }
  state.SetItemsProcessed(state.iterations() * group.lanes_of());
}

void step(benchmark::State& state, const std::string& scenario,
          const std::vector<std::string>& overrides, int lanes) {
  Group group(scenario, overrides, lanes);
  run(state, group, [](Group& g) { g.step(); });
}

void physics(benchmark::State& state, const std::string& scenario, int lanes) {
  Group group(scenario, {}, lanes);
  run(state, group, [](Group& g) { g.advance(); });
}

/// Task, ends and rows, without physics.
void rows(benchmark::State& state, const std::string& scenario) {
  Group group(scenario, {});
  run(state, group, [](Group& g) { g.evaluate(); });
}

const std::vector<std::string> kOnce = {"stepping.action_repeat=1"};
const std::vector<std::string> kSimbody = {"stepping.action_repeat=1", "stepping.dynamics=simbody"};
// A double-only controller between the shipped ones: it passes its input on, one lane after
// another.
const std::vector<std::string> kDoubleOnly = {
    "stepping.action_repeat=1",
    "robots.quad.controllers=[{plugin: rotor_speed, parameters: {max_speed: 2300}}, "
    "{plugin: slow_controller, parameters: {env: 1000000}}]"};
const std::string kPinRod = SKYBODY_BENCH_SCENARIOS "/pin_rod.yaml";

BENCHMARK_CAPTURE(step, hover_lanes, "hover", kOnce, 0);
BENCHMARK_CAPTURE(step, hover_one_by_one, "hover", kOnce, 1);
BENCHMARK_CAPTURE(step, hover_double_only_controller, "hover", kDoubleOnly, 0);
BENCHMARK_CAPTURE(step, hover_simbody, "hover", kSimbody, 1);
BENCHMARK_CAPTURE(step, payload_lanes, "payload", kOnce, 0);
BENCHMARK_CAPTURE(step, payload_one_by_one, "payload", kOnce, 1);
BENCHMARK_CAPTURE(step, pin_rod_lanes, kPinRod, kOnce, 0);
BENCHMARK_CAPTURE(step, formation_lanes, "formation", kOnce, 0);
BENCHMARK_CAPTURE(physics, hover_lanes, "hover", 0);
BENCHMARK_CAPTURE(physics, hover_one_by_one, "hover", 1);
BENCHMARK_CAPTURE(physics, payload_lanes, "payload", 0);
BENCHMARK_CAPTURE(rows, hover, "hover");
BENCHMARK_CAPTURE(rows, payload, "payload");
BENCHMARK_CAPTURE(rows, formation, "formation");

}  // namespace
}  // namespace skybody::bench
