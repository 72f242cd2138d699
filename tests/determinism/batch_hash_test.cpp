// One trajectory hash for every shipped scenario, and for one with all sensors, for all numbers of
// threads, batch sizes and orders, even while a neighbouring environment has a fault.
#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/base/math/random.h"
#include "core/batch/pool.h"
#include "core/io/files/shipped_files.h"
#include "core/policy/hold/hold_policy.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

constexpr int kEnvs = 6;
constexpr std::uint64_t kSeed = 7;
constexpr int kNobody = -1;

/// Action of step k of environment e, as in `skybody hash`. Environment `faulty` gets a NaN in step
/// 5.
std::vector<float> action_of(int env, int k, int width, int faulty) {
  Random<double> random({kSeed, static_cast<std::uint64_t>(env)}, 0, static_cast<std::uint64_t>(k),
                        derive_stream("hash.action"));
  std::vector<float> action(static_cast<std::size_t>(width));
  for (float& value : action) value = static_cast<float>(random.uniform(-1.0, 1.0));
  if (env == faulty && k == 5) action.back() = std::numeric_limits<float>::quiet_NaN();
  return action;
}

/// Hash after a reset and `steps` steps; an ended episode resets instead of stepping.
std::uint64_t hash_alone(const std::shared_ptr<const CompiledScenario>& compiled, int env,
                         int steps, int faulty) {
  Simulation simulation(compiled, kSeed, static_cast<std::uint64_t>(env));
  simulation.reset();
  for (int k = 0; k < steps; ++k) {
    if (simulation.done()) {
      simulation.reset();
    } else {
      simulation.step(action_of(env, k, simulation.action_size(), faulty));
    }
  }
  return simulation.hash();
}

/// Flies steps begin ... end - 1 of all environments; each is sent again as soon as it returns.
void fly(Pool& envs, int begin, int end, int faulty) {
  std::array<int, kEnvs> next;
  next.fill(begin);
  const auto send = [&](std::vector<std::int32_t> ids) {
    std::erase_if(ids, [&](std::int32_t e) { return next[static_cast<std::size_t>(e)] == end; });
    std::vector<float> actions;
    for (const std::int32_t env : ids) {
      const std::vector<float> row = action_of(env, next[static_cast<std::size_t>(env)]++,
                                               envs.compiled().action_size(), faulty);
      actions.insert(actions.end(), row.begin(), row.end());
    }
    if (!ids.empty()) envs.send(actions, ids);
  };
  send({0, 1, 2, 3, 4, 5});
  while (envs.in_flight() > 0) {
    const auto batch = envs.recv();
    send({batch->env_id.begin(), batch->env_id.begin() + batch->rows});
  }
}

void reset(Pool& envs) {
  envs.send_reset();
  while (envs.in_flight() > 0) envs.recv();
}

struct Shape {
  int threads, batch;
  Order order;
};

std::vector<Shape> shapes() {
  std::vector<Shape> all;
  for (const int threads : {1, 2, 4}) {
    for (const int batch : {kEnvs, kEnvs / 3, 1}) {
      for (const Order order : {Order::kFixed, Order::kArrival}) {
        all.push_back({threads, batch, order});
      }
    }
  }
  return all;
}

Pool make(const std::shared_ptr<const CompiledScenario>& compiled, const Shape& shape) {
  return Pool(compiled, {.envs = kEnvs,
                         .batch = shape.batch,
                         .threads = shape.threads,
                         .order = shape.order,
                         .seed = kSeed,
                         .keep_hash = true});
}

struct Flight {
  std::string name, scenario;
  std::vector<std::string> overrides = {};
};

void PrintTo(const Flight& flight, std::ostream* out) { *out << flight.name; }

std::vector<Flight> shipped_flights() {
  std::vector<Flight> flights;
  for (const std::string& name : shipped_scenarios()) flights.push_back({name, name});
  flights.push_back({"every_sensor", SKYBODY_SOURCE_DIR "/tests/golden/every_sensor.yaml"});
  return flights;
}

/// Integrators that no shipped scenario uses by default, on both dynamics.
std::vector<Flight> solvers() {
  std::vector<Flight> flights;
  for (const std::string dynamics : {"tree", "simbody"}) {
    for (const auto& [integrator, method] :
         {std::pair{"cvode", "adams"}, std::pair{"cvode", "bdf"}, std::pair{"arkode", "erk"},
          std::pair{"arkode", "dirk"}}) {
      flights.push_back(
          {dynamics + "_" + integrator + "_" + method,
           "hover",
           {"stepping.dynamics=" + dynamics, std::string("stepping.integrator=") + integrator,
            std::string("stepping.solver.method=") + method}});
    }
  }
  return flights;
}

class EveryShippedScenario : public testing::TestWithParam<Flight> {
 protected:
  std::shared_ptr<const CompiledScenario> compiled_ =
      compile_scenario({GetParam().scenario, GetParam().overrides, {}});
  /// Fewer steps for worlds of many robots and for error-controlled integrators, so that all
  /// scenarios take about the same time.
  int steps_ =
      std::max(8, 60 / static_cast<int>(compiled_->scenario().robots.size()) /
                      (is_error_controlled(compiled_->scenario().stepping.integrator) ? 6 : 1));

  std::array<std::uint64_t, kEnvs> alone(int faulty) const {
    std::array<std::uint64_t, kEnvs> hashes;
    for (int e = 0; e < kEnvs; ++e) {
      hashes[static_cast<std::size_t>(e)] = hash_alone(compiled_, e, steps_, faulty);
    }
    return hashes;
  }
  static void expect(const Pool& envs, const std::array<std::uint64_t, kEnvs>& hashes) {
    HashChain all;
    for (int e = 0; e < kEnvs; ++e) {
      ASSERT_EQ(envs.hash(e), hashes[static_cast<std::size_t>(e)])
          << "environment " << e << ", threads " << envs.threads() << ", batch " << envs.batch()
          << ", order " << static_cast<int>(envs.options().order);
      all.update(envs.hash(e));
    }
    EXPECT_EQ(envs.hash(), all.value());
  }
};

TEST_P(EveryShippedScenario, HasTheHashOfEnvironmentsAloneForAllThreadsBatchesAndOrders) {
  const auto hashes = alone(kNobody);
  std::vector<std::uint64_t> saved;
  for (const Shape& shape : shapes()) {
    Pool envs = make(compiled_, shape);
    reset(envs);
    fly(envs, 0, steps_ / 2, kNobody);
    if (!saved.empty()) envs.restore(saved);  // saved by a Pool of another shape
    saved = envs.save();
    fly(envs, steps_ / 2, steps_, kNobody);
    expect(envs, hashes);
  }
}

TEST_P(EveryShippedScenario, ANeighbourThatFaultsChangesNoOthersHash) {
  if (compiled_->action_size() == 0) GTEST_SKIP() << "no action with which to spoil a neighbour";
  const auto unharmed = alone(kNobody), harmed = alone(2);
  for (const Shape& shape : {Shape{2, kEnvs, Order::kFixed}, Shape{4, 2, Order::kArrival}}) {
    Pool envs = make(compiled_, shape);
    reset(envs);
    fly(envs, 0, steps_, 2);
    expect(envs, harmed);
    for (int e = 0; e < kEnvs; ++e) {
      const auto at = static_cast<std::size_t>(e);
      EXPECT_EQ(envs.hash(e) == unharmed[at], e != 2) << e;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, EveryShippedScenario, testing::ValuesIn(shipped_flights()),
                         [](const auto& flight) { return flight.param.name; });
INSTANTIATE_TEST_SUITE_P(Solvers, EveryShippedScenario, testing::ValuesIn(solvers()),
                         [](const auto& flight) { return flight.param.name; });

/// Denormals flushed and rounding downwards, as another library may leave the caller's thread.
TEST(CallersFloatingPointMode, MovesNoHash) {
  const auto compiled = compile_scenario({"hover", {}, {}});
  const auto run = [&](int envs_count) {
    Pool envs(compiled, {.envs = envs_count, .threads = 1, .keep_hash = true});
    reset(envs);
    const std::vector<float> actions(static_cast<std::size_t>(envs_count) * 4, 0.1f);
    for (int k = 0; k < 50; ++k) {
      envs.send(actions);
      envs.recv();
    }
    return envs.hash();
  };
  for (const int count : {1, 40}) {
    const std::uint64_t expected = run(count);
    const unsigned before = _mm_getcsr();
    _mm_setcsr(before | 0x8040u | 0x2000u);
    const std::uint64_t other = run(count);
    _mm_setcsr(before);
    EXPECT_EQ(other, expected) << count;
  }
}

TEST(CallersFloatingPointMode, MovesNothingInADirectWorld) {
  const auto compiled = compile_scenario({"hover", {}, {}});
  const auto run = [&] {
    Simulation simulation(compiled, kSeed, 0);
    simulation.reset();
    const std::vector<float> action(4, 0.1f);
    for (int k = 0; k < 20; ++k) {
      simulation.step(action);
      simulation.advance(3);
      simulation.evaluate();
    }
    return simulation.hash();
  };
  const std::uint64_t expected = run();
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040u | 0x2000u);
  const std::uint64_t other = run();
  _mm_setcsr(before);
  EXPECT_EQ(other, expected);
}

TEST(Groups, AreAsLargeAsThreadsBatchesAndDynamicsAllow) {
  const auto tree = compile_scenario({"hover", {}, {}});
  const auto simbody = compile_scenario({"hover", {"stepping.dynamics=simbody"}, {}});
  const auto lanes = [](const auto& compiled, int envs, int threads, int batch = 0,
                        Order order = Order::kFixed) {
    return Pool(compiled, {.envs = envs, .batch = batch, .threads = threads, .order = order})
        .lanes();
  };
  EXPECT_EQ(lanes(tree, 64, 1), 32);
  EXPECT_EQ(lanes(tree, 40, 1), 24);                      // two groups of about equal size
  EXPECT_EQ(lanes(tree, 63, 4), 16);                      // one group for each thread
  EXPECT_EQ(lanes(tree, 63, 2, 20, Order::kArrival), 8);  // quick lanes do not wait for slow ones
  EXPECT_EQ(lanes(tree, 15, 2), 1);  // a block of eight lanes would leave a thread idle
  EXPECT_EQ(lanes(simbody, 64, 1), 1);
}

/// Eight collisions, each with another vehicle, so that lanes touch at different times. The states
/// are saved and restored during the collisions, in lanes and one by one.
TEST(Collision, HasOneHashInLanesAndAlone) {
  constexpr int kLanes = 8, kSteps = 140, kMidst = 102;
  const auto compiled = compile_scenario({"collision", {}, {}});
  Simulation simulation(compiled, kSeed, 0);
  simulation.reset();
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  HoldPolicy(*compiled).act(simulation, action);  // both goals: the same in every step
  std::vector<float> actions;
  for (int e = 0; e < kLanes; ++e) actions.insert(actions.end(), action.begin(), action.end());
  std::vector<std::uint64_t> hashes, saved;
  for (const int threads : {1, 2}) {
    Pool envs(compiled, {.envs = kLanes, .threads = threads, .keep_hash = true});
    EXPECT_EQ(envs.lanes(), threads == 1 ? kLanes : 1);
    reset(envs);
    for (int e = 0; e < kLanes; ++e) {
      envs.set_param(e, "robots.left.links.base_link.mass", 1.54 + 0.02 * e);
    }
    for (int k = 0; k < kSteps; ++k) {
      if (k == kMidst && !saved.empty()) {
        EXPECT_EQ(envs.save(), saved);
        envs.restore(saved);
      }
      if (k == kMidst) saved = envs.save();
      envs.send(actions);
      envs.recv();
    }
    const StepCounts counts = envs.step_counts();
    EXPECT_GT(counts.near, kLanes * 20u);
    EXPECT_LT(counts.near, kLanes * 500u);
    EXPECT_EQ(counts.all, 10u * kSteps * kLanes);
    hashes.push_back(envs.hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

#ifdef SKYBODY_PROGRAM
std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  char line[256] = "";
  std::string text;
  while (std::fgets(line, sizeof line, pipe) != nullptr) text += line;
  pclose(pipe);
  return text;
}

TEST(AnotherProcess, HasTheHashOfThisOne) {
  for (const std::string name : {"hover", "payload"}) {
    Pool envs = make(compile_scenario({name, {}, {}}), {2, 2, Order::kArrival});
    reset(envs);
    fly(envs, 0, 60, kNobody);
    HashChain first;
    first.update(envs.hash(0));
    EXPECT_EQ(output_of(SKYBODY_PROGRAM " hash --steps 60 --seed 7 " + name),
              to_hex(first.value()) + "\n");
  }
}
#endif

}  // namespace
}  // namespace skybody
