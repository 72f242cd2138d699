// A whole hover step under each shipped chain of controllers, in lanes: what a mode costs is the
// difference to rotor_speed.
#include <benchmark/benchmark.h>

#include "bench/micro/group.h"

namespace skybody::bench {
namespace {

void control(benchmark::State& state, const std::string& chain) {
  Group group("hover", {"robots.quad.controllers=[" + chain + "]"});
  long step = 0;
  for ([[maybe_unused]] auto _ : state) {
    group.keep_flying(++step);
    group.step();
  }
  state.SetItemsProcessed(state.iterations() * group.lanes_of());
}

BENCHMARK_CAPTURE(control, rotor_speed, "{plugin: rotor_speed}");
BENCHMARK_CAPTURE(control, srt, "{plugin: srt}");
BENCHMARK_CAPTURE(control, ctbt, "{plugin: ctbt}");
BENCHMARK_CAPTURE(control, ctbr, "{plugin: ctbr}");
BENCHMARK_CAPTURE(control, wrench, "{plugin: wrench}");
BENCHMARK_CAPTURE(control, velocity, "{plugin: velocity}");
BENCHMARK_CAPTURE(control, pose, "{plugin: velocity, parameters: {form: position}}");
BENCHMARK_CAPTURE(control, attitude, "{plugin: attitude}, {plugin: ctbr}");
BENCHMARK_CAPTURE(control, position, "{plugin: position}, {plugin: attitude}, {plugin: ctbr}");
BENCHMARK_CAPTURE(control, indi_ctbr, "{plugin: indi, parameters: {signal: ctbr}}");
BENCHMARK_CAPTURE(control, indi_attitude, "{plugin: indi, parameters: {signal: attitude}}");
BENCHMARK_CAPTURE(control, indi, "{plugin: indi}");
BENCHMARK_CAPTURE(control, geometric_ctbt, "{plugin: geometric}, {plugin: ctbt}");
BENCHMARK_CAPTURE(control, geometric_ctbr,
                  "{plugin: geometric, parameters: {output: ctbr}}, {plugin: ctbr}");
BENCHMARK_CAPTURE(control, force, "{plugin: force}, {plugin: attitude}, {plugin: ctbr}");

}  // namespace
}  // namespace skybody::bench
