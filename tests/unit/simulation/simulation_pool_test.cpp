// Environments on several threads: the same bits as alone, errors with the environment's number, no
// hang.
#include "core/simulation/simulation_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/error.h"

namespace skybody {
namespace {

using testing::HasSubstr;

constexpr int kWorlds = 5;

std::shared_ptr<const CompiledScenario> hover() { return compile_scenario({"hover", {}, {}}); }

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

class AnyThreads : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(SimulationPool, AnyThreads, testing::Values(1, 2, 3, 9));

TEST_P(AnyThreads, WorldsDoWhatTheyDoAlone) {
  const auto compiled = hover();
  SimulationPool pool(compiled,
                      {.envs = kWorlds, .seed = 9, .first_env_id = 3, .threads = GetParam()});
  EXPECT_EQ(pool.threads(), GetParam());
  pool.reset(pool.all());
  std::vector<float> actions(kWorlds * 4);
  for (std::size_t k = 0; k < actions.size(); ++k) actions[k] = 0.01f * static_cast<float>(k);
  for (int k = 0; k < 50; ++k) pool.step(pool.all(), actions);
  const std::vector<int> some = {4, 1};
  pool.command(some, "quad", std::vector<double>{900, 900, 900, 900, 1200, 1200, 1200, 1200});
  pool.advance(some, 30);
  pool.evaluate(some);
  for (int i = 0; i < kWorlds; ++i) {
    Simulation alone(compiled, 9, 3 + static_cast<std::uint64_t>(i));
    alone.reset();
    for (int k = 0; k < 50; ++k)
      alone.step(std::span(actions).subspan(4 * static_cast<std::size_t>(i), 4));
    if (i == 4 || i == 1) {
      alone.command("", std::vector<double>(4, i == 4 ? 900.0 : 1200.0));
      alone.advance(30);
      alone.evaluate();
    }
    EXPECT_EQ(pool.simulation(i).hash(), alone.hash()) << i;
  }
}

TEST(SimulationPool, AllThreadsWorkAtTheSameTimeHoweverShortTheWorkBeforeWas) {
  constexpr int kThreads = 3;
  SimulationPool pool(hover(), {.envs = kWorlds, .pin_threads = true, .threads = kThreads});
  EXPECT_LT(pool.pinned_threads(), kThreads);  // the caller is not pinned
  for (int k = 0; k < 100; ++k) pool.run(pool.all(), [](Simulation&, int) {});
  std::atomic<int> inside{0};
  std::vector<std::thread::id> ids(kWorlds);
  // No call returns before one environment for each thread has entered: the run ends only if they
  // execute concurrently.
  pool.run(pool.all(), [&](Simulation&, int i) {
    ids[static_cast<std::size_t>(i)] = std::this_thread::get_id();
    ++inside;
    while (inside < kThreads) std::this_thread::yield();
  });
  EXPECT_EQ(inside, kWorlds);
  EXPECT_EQ(std::set<std::thread::id>(ids.begin(), ids.end()).size(),
            static_cast<std::size_t>(kThreads));
}

TEST(SimulationPool, PinsAsManyWorkersAsThereAreProcessorsBesideTheCallers) {
  const SimulationPool free(hover(), {.envs = kWorlds, .threads = 2});
  EXPECT_EQ(free.pinned_threads(), 0);
  const SimulationPool pinned(hover(), {.envs = kWorlds, .pin_threads = true, .threads = 2});
  EXPECT_LE(pinned.pinned_threads(), 1);
}

TEST(SimulationPool, EveryWorldIsDoneOnceForAnyNumberOfThem) {
  constexpr int kMany = 300;
  SimulationPool pool(hover(), {.envs = kMany, .threads = 3});
  std::vector<int> order(pool.all().rbegin(), pool.all().rend());
  for (std::size_t count = 1; count <= kMany; count += 23) {
    std::vector<std::atomic<int>> done(kMany);
    pool.run(std::span(order).first(count),
             [&](Simulation&, int i) { ++done[static_cast<std::size_t>(i)]; });
    for (std::size_t i = 0; i < kMany; ++i) EXPECT_EQ(done[i], i >= kMany - count ? 1 : 0) << i;
  }
}

TEST(SimulationPool, AnErrorNamesTheFirstWorldAndTheOthersFinish) {
  SimulationPool pool(hover(), {.envs = kWorlds});
  pool.reset(pool.all());
  std::atomic<int> finished{0};
  const auto work = [&](Simulation&, int i) {
    if (i == 3) throw std::runtime_error("lost its way");
    if (i == 2) throw 42;
    ++finished;
  };
  EXPECT_THAT(refusal([&] { pool.run(pool.all(), work); }), HasSubstr("environment 2: "));
  EXPECT_EQ(finished, kWorlds - 2);
  const std::vector<int> only = {3};
  EXPECT_EQ(refusal([&] { pool.run(only, work); }), "environment 3: lost its way");
  pool.advance(pool.all(), 1);  // it continues
  EXPECT_EQ(pool.simulation(3).physics_steps(), 1u);
}

TEST(SimulationPool, AStepBeforeAResetIsAnErrorOfThatWorldOnly) {
  SimulationPool pool(hover(), {.envs = 2});
  const std::vector<int> first = {0};
  pool.reset(first);
  EXPECT_EQ(refusal([&] { pool.advance(pool.all(), 1); }),
            "environment 1: advance() before reset(): begin an episode first");
  EXPECT_EQ(pool.simulation(0).physics_steps(), 1u);
}

TEST(SimulationPool, RefusesMisuseBeforeAnythingIsDone) {
  EXPECT_THROW(SimulationPool(hover(), {.envs = 0}), Error);
  EXPECT_THROW(SimulationPool(hover(), {.envs = 1, .threads = -1}), Error);
  SimulationPool pool(hover(), {.envs = 3});
  pool.reset(pool.all());
  const std::vector<int> twice = {1, 1}, beyond = {0, 3}, negative = {-1};
  for (const auto* envs : {&twice, &beyond, &negative}) {
    EXPECT_THROW(pool.advance(*envs, 1), Error);
  }
  EXPECT_THAT(refusal([&] { pool.step(pool.all(), std::vector<float>(11)); }),
              HasSubstr("actions has 11 values; expected 3 x 4"));
  EXPECT_THAT(refusal([&] { pool.command(pool.all(), "", std::vector<double>(4)); }),
              HasSubstr("values has 4 values; expected 3 x 4"));
  EXPECT_EQ(pool.simulation(0).physics_steps(), 0u);
  pool.advance({}, 5);  // no environment is a valid selection
}

TEST(SimulationPool, ClosesOnceOrTwiceAndRefusesAfterwards) {
  SimulationPool pool(hover(), {.envs = 2});
  pool.reset(pool.all());
  pool.close();
  pool.close();
  EXPECT_TRUE(pool.closed());
  EXPECT_THAT(refusal([&] { pool.reset(pool.all()); }), HasSubstr("closed"));
  EXPECT_THAT(refusal([&] { pool.simulation(0); }), HasSubstr("closed"));
}

}  // namespace
}  // namespace skybody
