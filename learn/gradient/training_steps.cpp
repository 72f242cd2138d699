#include "learn/gradient/training_steps.h"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "core/base/system/error.h"
#include "core/base/system/number_text.h"

namespace skybody::learn {
namespace {

/// Parameters of sensors that are numbers of physics steps.
constexpr const char* kTimes[] = {"period", "phase", "latency", "phase_spread", "latency_spread"};

bool is_time(const ParameterValue& value) {
  const bool is_named =
      std::find(std::begin(kTimes), std::end(kTimes), value.name) != std::end(kTimes);
  return is_named && value.is_given && value.type == ParameterType::kInteger;
}

bool is_observed(const CompiledScenario& compiled, int sensor) {
  const std::vector<ObservationColumn>& columns = compiled.columns();
  return std::any_of(columns.begin(), columns.end(),
                     [&](const ObservationColumn& c) { return c.source.sensor == sensor; });
}

/// A time of a sensor in longer physics steps. @param own  physics steps of an action
std::int64_t in_longer_steps(const CompiledScenario& compiled, const PluginUse& sensor,
                             const ParameterValue& time, int own, const PhysicsSteps& steps) {
  const auto now = static_cast<std::int64_t>(time.numbers[0]);
  const std::int64_t scaled = now * steps.count;
  if (scaled % own == 0) return scaled / own;
  throw Error("`" + compiled.scenario().name + "`: `" + time.name + "` of the sensor `" +
              sensor.instance + "` is " + std::to_string(now) + " physics steps of " +
              exact_text(compiled.scenario().stepping.dt) +
              " s, which are no whole number of the steps of " + exact_text(steps.dt) +
              " s in training: take another hyper-parameter physics_steps, such as 0, the "
              "scenario's own steps");
}

}  // namespace

PhysicsSteps training_steps(const CompiledScenario& compiled, const Hyperparameters& hyper) {
  const Stepping& own = compiled.scenario().stepping;
  if (hyper.physics_steps == 0 || hyper.physics_steps >= own.action_repeat) {
    return {own.dt, own.action_repeat};
  }
  return {own.dt * own.action_repeat / hyper.physics_steps, hyper.physics_steps};
}

std::vector<std::string> training_overrides(const CompiledScenario& compiled,
                                            const Hyperparameters& hyper) {
  const PhysicsSteps steps = training_steps(compiled, hyper);
  const int own = compiled.scenario().stepping.action_repeat;
  if (steps.count == own) return {};
  std::vector<std::string> overrides = {"stepping.dt=" + exact_text(steps.dt),
                                        "stepping.action_repeat=" + std::to_string(steps.count)};
  const std::vector<PluginUse>& sensors = compiled.scenario().sensors;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (!is_observed(compiled, static_cast<int>(s))) continue;
    for (const ParameterValue& value : sensors[s].parameters) {
      if (!is_time(value)) continue;
      const std::int64_t time = in_longer_steps(compiled, sensors[s], value, own, steps);
      overrides.push_back("sensors." + sensors[s].instance + ".parameters." + value.name + "=" +
                          std::to_string(time));
    }
  }
  return overrides;
}

}  // namespace skybody::learn
