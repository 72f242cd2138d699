// A small environment for the batch engine's tests: one quadrotor in the air and random starts. The
// task can be set, for each environment, to be slow, to throw, to wait or to fail.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/math/random.h"
#include "core/batch/pool.h"
#include "core/simulation/simulation.h"
#include "tests/unit/env/quadrotors_in_the_air.h"

namespace skybody::test {

/// Values of the task's parameter `task.mode`.
enum Mode : int {
  kPlain = 0,
  kSlow = 1,      ///< some 1000 times the work of a plain evaluation
  kThrow = 2,     ///< throws
  kWait = 3,      ///< waits at the gate, except on the gate keeper's own thread
  kBadReset = 4,  ///< the first observation of an episode is not finite
};

/// The gate at which environments with kWait wait.
struct Gate {
  std::atomic<bool> open{true};
  std::atomic<int> waiting{0};
  std::atomic<bool> fail{false};  ///< waiting environments throw
  std::atomic<std::thread::id> keeper{};
};
inline Gate gate;

/// Opens the gate at the end of a test, even after a failure.
struct ClosedGate {
  ClosedGate() {
    gate.keeper = std::this_thread::get_id();
    gate.open = false;
  }
  ~ClosedGate() { open(); }
  ClosedGate(const ClosedGate&) = delete;
  ClosedGate& operator=(const ClosedGate&) = delete;
  static void open() { gate.open = true; }
};

/// A random vertical speed at the start.
class Kick : public Randomizer {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    auto rng = random(env);
    start.u.set(5, rng.uniform(Real(-0.2), Real(0.2)));
  }
};

/// Observes height, vertical speed and a target drawn per episode; ends 1 cm from the start.
class Probe : public Task {
 public:
  struct State {
    double target;
  };
  RealParameter mode{this,
                     {.name = "mode",
                      .value = 0.0,
                      .min = 0.0,
                      .max = 4.0,
                      .doc = "what it does, see Mode",
                      .randomizable = true}};

  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.channel("vertical_speed", "m/s", 1, -kInfinity, kInfinity);
    setup.channel("target", "m", 1, 0, 1);
    setup.info("error", "m", 1);
  }
  void reset(const EnvView<double>& env, State& s) const {
    auto rng = random(env);
    s.target = rng.uniform();
  }
  void evaluate(const EnvView<double>& env, State& s, Evaluation<double>& out) const {
    const BodyMotion<double> b = env.body(0);
    const int what = static_cast<int>(mode(env));
    if (what != kPlain) act_up(what);
    const bool bad = what == kBadReset && env.step() == 0;
    out.observation.set(0, bad ? std::numeric_limits<double>::quiet_NaN() : b.position.z);
    out.observation.set(1, b.velocity.z);
    out.observation.set(2, s.target);
    out.info.set(0, b.position.z - s.target);
    out.set_reward(s.target - b.position.z);
    out.terminate(std::abs(b.position.z - 1.0) > 0.01);
  }

 private:
  static void act_up(int what) {
    if (what == kThrow) throw std::logic_error("thrown by the task");
    if (what == kSlow) {
      volatile double sum = 0.0;
      for (int i = 0; i < 500000; ++i) sum = sum + 1.0;
    }
    if (what == kWait && std::this_thread::get_id() != gate.keeper.load()) {
      ++gate.waiting;
      while (!gate.open) std::this_thread::yield();
      --gate.waiting;
      if (gate.fail) throw std::logic_error("thrown by the task");
    }
  }
};

/// 5 ms per transition, at most 12 transitions per episode: about half of the episodes end earlier.
inline Scenario small_scenario(InProcessFactory& factory) {
  factory.add<Direct>("direct");
  factory.add<Kick>("kick");
  factory.add<Probe>("probe");
  Scenario s = empty_air("small");
  s.stepping.action_repeat = 5;
  s.robots.push_back(quadrotor_at(0.0, "quad", factory));
  s.randomization.push_back(factory.use("kick", "kick"));
  s.task = factory.use("probe", "task");
  return s;
}

inline std::shared_ptr<const CompiledScenario> small_env() {
  InProcessFactory factory;
  return std::make_shared<CompiledScenario>(small_scenario(factory), factory);
}

/// The action of an environment's k-th transition: a function of (env, k) only.
inline std::vector<float> action_of(int env, int k, int width) {
  Random<double> rng({99, static_cast<std::uint64_t>(env)}, 0, static_cast<std::uint64_t>(k), 1);
  std::vector<float> out(static_cast<std::size_t>(width));
  for (float& a : out) a = static_cast<float>(rng.uniform(-0.3, 0.5));
  return out;
}

inline std::vector<float> actions_of(const std::vector<std::int32_t>& envs, int k, int width) {
  std::vector<float> out;
  for (const std::int32_t env : envs) {
    const std::vector<float> row = action_of(env, k, width);
    out.insert(out.end(), row.begin(), row.end());
  }
  return out;
}

/// Flies transitions 0 ... count - 1 of every environment, sends each one as soon as it returns,
/// and calls `on_row(batch, i)` for every row. Transition 0 is a reset if `begin` is true.
template <class OnRow>
void fly(Pool& envs, int begin, int end, OnRow&& on_row) {
  const auto n = static_cast<std::size_t>(envs.envs());
  const int width = envs.compiled().action_size();
  std::vector<int> next(n, begin);
  std::vector<std::int32_t> ids(n);
  for (std::size_t e = 0; e < n; ++e) ids[e] = static_cast<std::int32_t>(e);
  std::vector<std::uint8_t> ended(n);
  const auto send = [&] {
    std::vector<std::uint8_t> resets(n);
    std::vector<std::int32_t> steps;
    std::vector<float> actions;
    for (const std::int32_t env : ids) {
      const auto e = static_cast<std::size_t>(env);
      const int k = next[e]++;
      if (k == end) continue;
      if (k == 0 || (envs.options().autoreset == Autoreset::kDisabled && ended[e] != 0)) {
        resets[e] = 1;
        continue;
      }
      const std::vector<float> row = action_of(env, k, width);
      actions.insert(actions.end(), row.begin(), row.end());
      steps.push_back(env);
    }
    if (std::count(resets.begin(), resets.end(), 1) > 0) envs.send_reset(resets);
    if (!steps.empty()) envs.send(actions, steps);
  };
  send();
  while (envs.in_flight() > 0) {
    const std::shared_ptr<const Batch> batch = envs.recv();
    ids.assign(batch->env_id.begin(), batch->env_id.begin() + batch->rows);
    for (int i = 0; i < batch->rows; ++i) {
      const auto at = static_cast<std::size_t>(i);
      ended[static_cast<std::size_t>(ids[at])] = batch->status[at] != kRunning;
      on_row(*batch, i);
    }
    send();
  }
}

inline void fly(Pool& envs, int begin, int end) {
  fly(envs, begin, end, [](const Batch&, int) {});
}

/// Resets and waits for all.
inline void begin(Pool& envs) {
  envs.send_reset();
  while (envs.in_flight() > 0) envs.recv();
}

}  // namespace skybody::test
