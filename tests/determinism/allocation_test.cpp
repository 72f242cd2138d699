// No allocation of ours in the step path. operator new is replaced, and every call from libskybody
// or a plugin during a step is counted. Not counted: Simbody's own allocations (13 a step in the
// air), which come from its libraries, and those of SUNDIALS, which is written in C. Without these
// two libraries a step allocates nothing.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/batch/pool.h"
#include "core/policy/hold/hold_policy.h"
#include "core/simulation/simulation.h"
#include "learn/network/adam.h"
#include "learn/network/noise.h"
#include "learn/network/recurrent_network.h"
#include "learn/ppo/ppo.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<int> ours_counted{0}, all_counted{0};

bool is_ours(void* caller) {
  Dl_info info;
  if (dladdr(caller, &info) == 0 || info.dli_fname == nullptr) return false;
  const char* name = std::strrchr(info.dli_fname, '/');
  name = name == nullptr ? info.dli_fname : name + 1;
  return std::strncmp(name, "libskybody", 10) == 0 ||
         std::strstr(info.dli_fname, "skybody/plugins/") != nullptr;
}

[[gnu::noinline]] void note(void* caller) {
  thread_local bool noting = false;  // dladdr must not count itself
  if (noting || !counting.load()) return;
  noting = true;
  ++all_counted;
  if (is_ours(caller)) ++ours_counted;
  noting = false;
}

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  note(__builtin_return_address(0));
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new[](std::size_t size) {
  note(__builtin_return_address(0));
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  note(__builtin_return_address(0));
  const auto a = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

namespace skybody {
namespace {

class NoAllocation : public testing::TestWithParam<const char*> {};

TEST_P(NoAllocation, OfOursHappensWhileStepping) {
  Simulation simulation({.scenario = GetParam()});
  HoldPolicy hold(simulation.compiled());
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  hold.act(simulation, action);
  for (int i = 0; i < 10; ++i) simulation.step(action);  // caches fill
  ours_counted = all_counted = 0;
  for (int i = 0; i < 50; ++i) {
    hold.act(simulation, action);  // a baseline may allocate
    counting = true;
    simulation.step(action);
    counting = false;
  }
  EXPECT_EQ(ours_counted.load(), 0) << "of " << all_counted.load() << " in all";
  const bool simbody =
      simulation.compiled().scenario().stepping.dynamics == DynamicsChoice::kSimbody;
  EXPECT_EQ(all_counted.load() > 0, simbody) << all_counted.load();
}

TEST(Allocation, DoesNotHappenInACollision) {
  Simulation simulation({.scenario = "collision"});
  simulation.keep_hash(false);
  HoldPolicy hold(simulation.compiled());
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  hold.act(simulation, action);
  simulation.step(action);
  const std::uint64_t before = simulation.step_counts().near;
  ours_counted = all_counted = 0;
  for (int i = 0; i < 150; ++i) {
    hold.act(simulation, action);
    counting = true;
    simulation.step(action);
    counting = false;
  }
  EXPECT_GT(simulation.step_counts().near, before);
  EXPECT_EQ(all_counted.load(), 0);
}

TEST(Allocation, IsCounted) {
  all_counted = 0;
  counting = true;
  const std::vector<float> some(100);
  counting = false;
  EXPECT_EQ(all_counted.load(), 1) << "is operator new still replaced? " << some.size();
}

/// Forward pass, backward pass and an optimiser step; every other call has fewer rows.
TEST(Allocation, DoesNotHappenInAnUpdateOfANetworkAfterTheFirst) {
  const Isa isa = best_isa();
  const learn::RecurrentNetwork network({7, 20, {40}, 3, Activation::kTanh}, isa);
  std::vector<float> parameters(network.parameter_count()), gradient(parameters.size());
  network.initialize(parameters, 1.0, 1, 2);
  learn::Adam adam(parameters.size(), 0.5, isa);
  learn::TransposedRecurrent transposed;
  learn::RecurrentActivations memory;
  constexpr int kSequences = 9, kSteps = 50;
  std::vector<float> x(kSequences * kSteps * 7), y(kSequences * kSteps * 3), dx(x.size());
  std::vector<float> states(static_cast<std::size_t>(kSequences * network.state_stride()));
  const auto update = [&](int sequences) {
    learn::draw_normals({}, x, isa);
    network.transpose(parameters, transposed);
    network.forward(parameters, x.data(), 7, {sequences, kSteps}, nullptr, states.data(), memory,
                    y.data(), 3);
    network.backward(transposed, x.data(), 7, nullptr, memory, y.data(), 3, gradient, dx.data(), 7);
    const float* const gradients[] = {gradient.data()};
    adam.sum(gradients);
    adam.step(parameters, 1e-3);
  };
  update(kSequences);
  all_counted = 0;
  counting = true;
  for (const int sequences : {kSequences - 2, kSequences, 1}) update(sequences);
  counting = false;
  EXPECT_EQ(all_counted.load(), 0);
}

/// Both vectors of a report, and the names of losses that are too long for the small-string buffer.
TEST(Allocation, OfAnIterationIsItsReportAlone) {
  learn::LearnerOptions options;
  options.compiled = compile_scenario({"hover_learn", {}, {}});
  options.total_steps = 1000000;
  options.threads = 2;
  options.hyper.envs = 64;
  options.hyper.rollout_steps = 16;
  options.hyper.minibatch = 100;
  learn::Ppo ppo(options);
  for (int k = 0; k < 24; ++k) ppo.iterate();  // 384 steps: every environment has reset
  ours_counted = 0;
  counting = true;
  constexpr int kIterations = 5;
  for (int k = 0; k < kIterations; ++k) ppo.iterate();
  counting = false;
  EXPECT_LE(ours_counted.load(), 6 * kIterations);
}

/// Ids above 999: their text no longer fits into a small string.
constexpr int kEnvs = 1010;

class NoAllocationInBatches : public testing::TestWithParam<PoolOptions> {};

TEST_P(NoAllocationInBatches, OfOursHappensWhileSendingAndReceiving) {
  PoolOptions options = GetParam();
  options.envs = kEnvs;
  const auto compiled = compile_scenario({"hover", {}, {}});
  Pool envs(compiled, options);
  envs.send_reset();
  std::vector<std::int32_t> ids;
  ids.reserve(kEnvs);
  const std::vector<float> actions(kEnvs * static_cast<std::size_t>(compiled->action_size()));
  std::vector<int> received(kEnvs);
  const auto step = [&] {
    const auto batch = envs.recv();
    for (int k = 0; k < batch->rows; ++k) {
      ++received[static_cast<std::size_t>(batch->env_id[static_cast<std::size_t>(k)])];
    }
    ids.assign(batch->env_id.begin(), batch->env_id.begin() + batch->rows);
    envs.send(std::span(actions).first(ids.size() * 4), ids);
  };
  const int cycle = kEnvs / envs.batch();
  // Caches fill. In order of arrival, an environment whose thread sleeps may be far behind the
  // others.
  while (*std::min_element(received.begin(), received.end()) < 6) step();
  ours_counted = all_counted = 0;
  counting = true;
  for (int i = 0; i < 4 * cycle; ++i) step();
  counting = false;
  EXPECT_EQ(all_counted.load(), 0) << "a free body needs none at all, not even a library's";
  while (envs.in_flight() > 0) envs.recv();
}

/// On the ground and on a joint: queries of contact and joint forces allocate only the first time.
TEST(Allocation, DoesNotHappenWherePluginsAskWhatBodiesFeel) {
  Simulation simulation(
      {.scenario = "payload",
       .overrides = {"sensors=[{plugin: feeling_sensor}]", "robots.quad.pose.position=[0, 0, 0.3]"},
       .plugin_path = {SKYBODY_BINARY_DIR "/tests/plugins/good"}});
  const std::vector<float> idle(static_cast<std::size_t>(simulation.action_size()), -1.0f);
  simulation.reset();
  for (int i = 0; i < 200; ++i) simulation.step(idle);  // caches fill
  ASSERT_FALSE(simulation.contacts().empty());
  all_counted = 0;
  counting = true;
  for (int i = 0; i < 20; ++i) simulation.step(idle);
  counting = false;
  EXPECT_EQ(all_counted.load(), 0);
}

TEST(Allocation, DoesNotHappenInModelPredictiveControl) {
  if (!std::filesystem::exists(SKYBODY_BINARY_DIR "/lib/skybody/plugins/nmpc.so")) {
    GTEST_SKIP() << "built without DAQP";
  }
  Simulation simulation({.scenario = "hover",
                         .overrides = {"robots[0].controllers=[{plugin: nmpc}, {plugin: srt}]"}});
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  simulation.step(action);
  all_counted = 0;
  for (int i = 0; i < 100; ++i) {
    action[static_cast<std::size_t>(i % 3)] = i % 2 == 0 ? 1.0f : -1.0f;  // rotors saturate
    counting = true;
    simulation.step(action);
    counting = false;
  }
  EXPECT_EQ(all_counted.load(), 0);
}

TEST(Allocation, DoesNotHappenWhereRotorsSaturateByLeastSquares) {
  for (const char* plugin : {"ctbt", "indi"}) {
    const std::string chain = std::string("robots[0].controllers=[{plugin: ") + plugin +
                              ", parameters: {allocation: qp}}]";
    Simulation simulation({.scenario = "hover", .overrides = {chain}});
    std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
    simulation.reset();
    simulation.step(action);
    all_counted = 0;
    for (int i = 0; i < 100; ++i) {
      action[static_cast<std::size_t>(i % 4)] = i % 2 == 0 ? 1.0f : -1.0f;
      counting = true;
      simulation.step(action);
      counting = false;
    }
    EXPECT_EQ(all_counted.load(), 0) << plugin;
  }
}

TEST(Allocation, DoesNotHappenWhileTheStateIsRead) {
  const auto compiled = compile_scenario({"hover", {}, {}});
  Pool envs(compiled, {.envs = kEnvs, .threads = 2});
  envs.send_reset();
  envs.recv();
  std::vector<double> values(kEnvs * 4);
  all_counted = 0;
  counting = true;
  envs.state("robots.quad.base.rotation", values);
  envs.state("robots.quad.rotors.speed", values);
  counting = false;
  EXPECT_EQ(all_counted.load(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, NoAllocationInBatches,
    testing::Values(PoolOptions{.batch = kEnvs, .threads = 2},
                    PoolOptions{.batch = kEnvs / 5, .threads = 2},
                    PoolOptions{.batch = kEnvs / 5, .threads = 4, .order = Order::kArrival},
                    PoolOptions{.batch = kEnvs, .threads = 1, .autoreset = Autoreset::kSameStep},
                    PoolOptions{.batch = kEnvs, .threads = 2, .keep_hash = true}));

INSTANTIATE_TEST_SUITE_P(Scenarios, NoAllocation,
                         testing::Values("hover", "payload", "formation", "collision",
                                         "hard_landing", "cooperative_payload", "gates",
                                         "platform_landing", "landing", "racing_duel",
                                         "racing_drawn", "four_bar", "windy_hover", "downwash_pair",
                                         "low_battery", "rotor_out", "arm", "payload_paper",
                                         "vehicles", "omav", "formation_obstacles", "obstacles",
                                         "chase", "pendulum", "trajectory", "hover_sensors"));

}  // namespace
}  // namespace skybody
