// A whole hover step under each shipped chain of controllers, in lanes: the cost of a mode is the
// difference to rotor_speed.
#include <benchmark/benchmark.h>

#include "research/bench/micro/group.h"

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

/// Chains that begin with a law, in steady flight. Their command is the middle of every range: a
/// position, at rest. The cost of a law's own evaluation is the difference to the row with the same
/// command and the same following controllers, in which `balance` of research/bench/plugins, which
/// computes nothing, replaces the law. The share of hover is that difference over `hover`, whose
/// actions are the hover speeds of the rotors.
void law(benchmark::State& state, const std::string& chain, float action) {
  Group group("hover", {"robots.quad.controllers=[" + chain + "]"});
  group.hold(action);
  constexpr long kArrival = 4000;  // steps until all lanes have arrived
  long step = 0;
  const auto begin = [&] {
    group.reset();
    for (long i = 0; i < kArrival; ++i) group.step();
    step = 0;
  };
  begin();
  for ([[maybe_unused]] auto _ : state) {
    if (++step + kArrival >= 20000) {  // the episode's end
      state.PauseTiming();
      begin();
      state.ResumeTiming();
    }
    group.step();
  }
  state.SetItemsProcessed(state.iterations() * group.lanes_of());
}

std::string with(const std::string& plugin, const std::string& parameters) {
  return "{plugin: " + plugin + ", parameters: {" + parameters + "}}, ";
}

// For rotors, action a is (a + 1) 2246 / 2 rad/s: QDrone2 hovers at 1390.6 rad/s.
constexpr float kHoverSpeed = 0.23829f;
const std::string kCtbr = "{plugin: ctbr}", kCtbt = "{plugin: ctbt}";
const std::string kRotors = "{plugin: rotor_speed}";
const std::string kAttitude = "{plugin: attitude}, " + kCtbr;
const std::string kRates = with("attitude", "feed_forward: true") + kCtbr;

BENCHMARK_CAPTURE(law, hover, "{plugin: rotor_speed}", kHoverSpeed);
BENCHMARK_CAPTURE(law, nothing_to_ctbt, with("balance", "gives: ctbt") + kCtbt, 0.0f);
BENCHMARK_CAPTURE(law, geometric_to_ctbt, with("geometric", "output: ctbt") + kCtbt, 0.0f);
BENCHMARK_CAPTURE(law, lqr_to_ctbt, with("lqr", "output: ctbt") + kCtbt, 0.0f);
BENCHMARK_CAPTURE(law, sliding_mode_to_ctbt, "{plugin: sliding_mode}, " + kCtbt, 0.0f);
BENCHMARK_CAPTURE(law, nothing_to_ctbr, with("balance", "gives: ctbr") + kCtbr, 0.0f);
BENCHMARK_CAPTURE(law, geometric_to_ctbr, with("geometric", "output: ctbr") + kCtbr, 0.0f);
BENCHMARK_CAPTURE(law, nothing_to_rates, with("balance", "gives: attitude_with_rates") + kRates,
                  0.0f);
BENCHMARK_CAPTURE(law, position_to_rates, with("position", "signal: trajectory") + kRates, 0.0f);
BENCHMARK_CAPTURE(law, flatness_to_rates, "{plugin: flatness}, " + kRates, 0.0f);
BENCHMARK_CAPTURE(law, nothing_to_attitude,
                  with("balance", "takes: force, gives: attitude") + kAttitude, 0.0f);
BENCHMARK_CAPTURE(law, force_to_attitude, "{plugin: force}, " + kAttitude, 0.0f);
BENCHMARK_CAPTURE(law, nothing_to_rotors, with("balance", "gives: rotor_speed") + kRotors, 0.0f);
BENCHMARK_CAPTURE(law, indi_to_rotors, "{plugin: indi}, " + kRotors, 0.0f);

}  // namespace
}  // namespace skybody::bench
