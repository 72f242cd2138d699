#include "research/bench/limit/engine_check.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/error.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"
#include "research/bench/limit/array.h"
#include "research/bench/limit/hover_task.h"
#include "research/bench/limit/pin_rod_task.h"

namespace skybody::bench::limit {
namespace {

constexpr int kGroup = 8;  // environments compared: one block of eight lanes of the engine

/// Actions in [middle - spread, middle + spread], a fixed sequence.
class Actions {
 public:
  Actions(float middle, float spread) : middle_(middle), spread_(spread) {}
  void fill(std::vector<float>& rows) {
    for (float& a : rows) {
      seed_ = seed_ * 6364136223846793005u + 1442695040888963407u;
      const auto high = static_cast<float>(seed_ >> 40) * 0x1p-23f;  // 0 ... 2
      a = middle_ + spread_ * (high - 1.0f);
    }
  }

 private:
  float middle_, spread_;
  std::uint64_t seed_ = 1;
};

/// With nominal constants.
LoadOptions team_of(const char* scenario, const std::string& repeat) {
  return {scenario,
          {repeat,
           "randomization=[{plugin: start, parameters: {relative: true, together: true, "
           "position_min: [-10, -10, -10], position_max: [10, 10, 10], min_height: 1.5}}]"},
          {}};
}

LoadOptions scenario_of(CheckedTask task, int repeats) {
  const std::string repeat = "stepping.action_repeat=" + std::to_string(repeats);
  switch (task) {
    case CheckedTask::kPayload:  // nominal constants; a hanging load at rest shows little
      return {"payload",
              {repeat, "sensors=[]",
               "randomization=[{plugin: start, parameters: {robot: quad, position_min: [-5, -5, "
               "1.5], position_max: [5, 5, 3], rate_max: 1.0, velocity_max: 1.0}}]"},
              {}};
    case CheckedTask::kPinRod:
      return {SKYBODY_BENCH_SCENARIOS "/pin_rod.yaml", {repeat}, {}};
    case CheckedTask::kTeamOf2:
      return team_of("formation_2", repeat);
    case CheckedTask::kTeamOf20:
      return team_of("formation_20", repeat);
    case CheckedTask::kHover:
      break;
  }
  return {"hover", {repeat}, {}};
}

/// Eight environments of the scenario, in lanes.
class Engine {
 public:
  Engine(CheckedTask task, int repeats)
      : compiled_(compile_scenario(scenario_of(task, repeats))),
        group_(compiled_->make_state(compiled_->preferred_lanes())),
        work_(compiled_->make_workspace(group_.lanes())),
        observation_(static_cast<std::size_t>(compiled_->observation_size()) * kGroup) {
    for (int l = 0; l < kGroup; ++l) {
      compiled_->initialize(group_, l, 7, static_cast<std::uint64_t>(l));
    }
    compiled_->reset(group_, *work_, kAll, rows());
  }
  void step(const std::vector<float>& actions) {
    compiled_->step(group_, *work_, kAll, actions.data(), compiled_->action_size(), rows());
  }
  double q(int lane, int k) { return value(compiled_->layout().q.offset + k, lane); }
  double u(int lane, int k) { return value(compiled_->layout().u.offset + k, lane); }
  double rotor(int lane, int k) { return value(compiled_->layout().rotor_speed.offset + k, lane); }
  /// @param path  of an EnvParam
  double param(int lane, const std::string& path) {
    const StateLayout& layout = compiled_->layout();
    for (std::size_t k = 0; k < layout.param_info.size(); ++k) {
      if (layout.param_info[k].path == path) {
        return value(layout.params.offset + static_cast<int>(k), lane);
      }
    }
    throw Error("no parameter " + path);
  }
  int width() const { return compiled_->observation_size(); }
  const float* observation(int lane) const {
    return observation_.data() + static_cast<std::ptrdiff_t>(lane) * width();
  }
  float reward(int lane) const { return reward_[lane]; }

 private:
  static constexpr std::uint32_t kAll = (1u << kGroup) - 1u;
  double value(int word, int lane) { return group_.reals(word)[lane]; }
  skybody::Rows rows() { return {observation_.data(), reward_, status_}; }

  std::shared_ptr<const CompiledScenario> compiled_;
  StateGroup group_;
  std::unique_ptr<GroupWorkspace> work_;
  std::vector<float> observation_;
  float reward_[kGroup] = {};
  std::uint64_t status_[kGroup] = {};
};

/// The engine's bases come first in both arrays.
void copy_base(Engine& engine, EnvironmentArray& array, int env, int robot = 0) {
  const int to = robot * kFlyerValues;
  for (int k = 0; k < 7; ++k) array.value(env, to + k) = engine.q(env, 7 * robot + k);
  for (int k = 0; k < 6; ++k) array.value(env, to + kVelocity + k) = engine.u(env, 6 * robot + k);
  for (int k = 0; k < 4; ++k) array.value(env, to + kRotor + k) = engine.rotor(env, 4 * robot + k);
}

/// @param first  index of the target's values
void copy_target(Engine& engine, EnvironmentArray& array, int env, int first, int count) {
  for (int k = 0; k < count; ++k) {
    array.value(env, first + k) = engine.param(env, "task.target[" + std::to_string(k) + "]");
  }
}

void copy_team(Engine& engine, EnvironmentArray& array, int env, int robots) {
  for (int i = 0; i < robots; ++i) copy_base(engine, array, env, i);
  copy_target(engine, array, env, robots * kFlyerValues, 3);
}

/// Coordinates of ball joints are those of the loop.
void copy_bodies(Engine& engine, EnvironmentArray& array, int env) {
  for (int body = 0; body < 2; ++body) {
    const int to = kRodRotation + 7 * body;
    for (int k = 0; k < 4; ++k) array.value(env, to + k) = engine.q(env, 7 + 4 * body + k);
    for (int k = 0; k < 3; ++k) array.value(env, to + 4 + k) = engine.u(env, 6 + 3 * body + k);
  }
}

void copy_state(CheckedTask task, Engine& engine, EnvironmentArray& array, int env) {
  copy_base(engine, array, env);
  switch (task) {
    case CheckedTask::kHover:
      return copy_target(engine, array, env, kTarget, 4);
    case CheckedTask::kTeamOf2:
      return copy_team(engine, array, env, 2);
    case CheckedTask::kTeamOf20:
      return copy_team(engine, array, env, 20);
    case CheckedTask::kPayload:
      copy_bodies(engine, array, env);
      return;
    case CheckedTask::kPinRod:
      array.value(env, kPinAngle) = engine.q(env, 7);
      array.value(env, kPinRate) = engine.u(env, 6);
      return;
  }
}

void raise(double& largest, double a, double b) {
  largest = std::fmax(largest, std::isnan(a - b) ? INFINITY : std::fabs(a - b));
}

}  // namespace

Difference compare_with_engine(CheckedTask task, const LoopKind& loop, int repeats, int steps) {
  Engine engine(task, repeats);
  EnvironmentArray array(loop, kGroup, repeats);
  // Actions near hover, so that no episode ends; larger ones with a hanging load.
  const bool carries = task == CheckedTask::kPayload || task == CheckedTask::kPinRod;
  Actions actions(carries ? 0.3f : 0.21f, 0.05f);
  std::vector<float> rows(static_cast<std::size_t>(kGroup * loop.actions));
  actions.fill(rows);
  array.step(rows.data());  // begins the episodes; the engine's initial states then replace theirs
  std::vector<float> start;
  for (int e = 0; e < kGroup; ++e) {
    copy_state(task, engine, array, e);
    start.insert(start.end(), engine.observation(e), engine.observation(e) + engine.width());
  }
  for (int n = 0; n < steps; ++n) {
    actions.fill(rows);
    engine.step(rows);
    array.step(rows.data());
  }
  Difference out;
  for (int e = 0; e < kGroup; ++e) {
    for (int k = 0; k < engine.width(); ++k) {
      raise(out.observation, array.observation(e)[k], engine.observation(e)[k]);
      raise(out.moved, start[static_cast<std::size_t>(e * engine.width() + k)],
            engine.observation(e)[k]);
    }
    raise(out.reward, array.reward(e), engine.reward(e));
  }
  return out;
}

bool give_same_rows(const LoopKind& a, const LoopKind& b, int repeats, int rounds) {
  constexpr int kEnvs = 64;
  EnvironmentArray first(a, kEnvs, repeats), second(b, kEnvs, repeats);
  const auto bytes = static_cast<std::size_t>(a.observation) * sizeof(float);
  Actions actions(0.2f, 1.0f);
  std::vector<float> rows(static_cast<std::size_t>(kEnvs * a.actions));
  for (int n = 0; n < rounds; ++n) {
    actions.fill(rows);
    first.step(rows.data());
    second.step(rows.data());
    for (int e = 0; e < kEnvs; ++e) {
      if (std::memcmp(first.observation(e), second.observation(e), bytes) != 0 ||
          first.reward(e) != second.reward(e) || first.ended(e) != second.ended(e)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace skybody::bench::limit
