// Rows of a Pool against single Simulations of the same seed and ids, bit for bit.
#include <gtest/gtest.h>

#include <cstring>
#include <tuple>
#include <vector>

#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::action_of;
using test::fly;
using test::small_env;

constexpr int kEnvs = 6;
constexpr int kTransitions = 80;
constexpr std::uint64_t kSeed = 11;
constexpr std::uint64_t kFirstId = 100;

/// One environment, stepped by hand.
class ByHand {
 public:
  ByHand(const std::shared_ptr<const CompiledScenario>& compiled, int env, Autoreset autoreset)
      : simulation_(compiled, kSeed, kFirstId + static_cast<std::uint64_t>(env)),
        env_(env),
        autoreset_(autoreset) {}

  /// Compares the next transition with the batch's row.
  void expect(const Batch& batch, int i) {
    const auto at = static_cast<std::size_t>(i);
    const bool begins = k_ == 0 || (simulation_.done() && autoreset_ != Autoreset::kSameStep);
    if (begins) {
      simulation_.reset();
    } else {
      simulation_.step(action_of(env_, k_, 4));
    }
    ++k_;
    EXPECT_EQ(batch.was_reset[at], begins);
    EXPECT_EQ(batch.reward[at], simulation_.reward());
    EXPECT_EQ(batch.agent_reward[at], simulation_.agent_rewards()[0]);
    EXPECT_EQ(batch.status[at], simulation_.status());
    EXPECT_EQ(batch.terminated[at], simulation_.terminated());
    EXPECT_EQ(batch.truncated[at], simulation_.truncated());
    EXPECT_EQ(batch.fault[at], 0);
    EXPECT_EQ(batch.episode_step[at], static_cast<std::int32_t>(simulation_.steps()));
    terminations += simulation_.terminated();
    truncations += simulation_.truncated();
    if (autoreset_ == Autoreset::kSameStep && simulation_.done()) {
      same(batch.final_observation, simulation_.observation(), i);
      same(batch.final_info, simulation_.info(), i);
      simulation_.reset();
    }
    same(batch.observation, simulation_.observation(), i);
    same(batch.info, simulation_.info(), i);
  }

  int terminations = 0, truncations = 0;
  std::uint64_t hash() const { return simulation_.hash(); }

 private:
  static void same(const Column<float>& column, std::span<const float> expected, int i) {
    const float* row = column.data() + static_cast<std::size_t>(i) * expected.size();
    EXPECT_EQ(std::memcmp(row, expected.data(), expected.size_bytes()), 0)
        << row[0] << " and " << expected[0];
  }
  Simulation simulation_;
  int env_, k_ = 0;
  Autoreset autoreset_;
};

using Case = std::tuple<Autoreset, int, int, Order>;  // autoreset, threads, batch, order
class EveryRow : public testing::TestWithParam<Case> {};

TEST_P(EveryRow, HasTheBitsOfAnEnvironmentSteppedByHand) {
  const auto [autoreset, threads, batch_size, order] = GetParam();
  const auto compiled = small_env();
  Pool envs(compiled, {.envs = kEnvs,
                       .batch = batch_size,
                       .threads = threads,
                       .order = order,
                       .autoreset = autoreset,
                       .seed = kSeed,
                       .first_env_id = kFirstId,
                       .keep_hash = true});
  std::vector<ByHand> by_hand;
  for (int e = 0; e < kEnvs; ++e) by_hand.emplace_back(compiled, e, autoreset);
  int rows = 0;
  fly(envs, 0, kTransitions, [&](const Batch& batch, int i) {
    const std::int32_t env = batch.env_id[static_cast<std::size_t>(i)];
    SCOPED_TRACE("environment " + std::to_string(env));
    by_hand[static_cast<std::size_t>(env)].expect(batch, i);
    ++rows;
  });
  EXPECT_EQ(rows, kEnvs * kTransitions);
  int terminations = 0, truncations = 0;
  for (int e = 0; e < kEnvs; ++e) {
    EXPECT_EQ(envs.hash(e), by_hand[static_cast<std::size_t>(e)].hash());
    terminations += by_hand[static_cast<std::size_t>(e)].terminations;
    truncations += by_hand[static_cast<std::size_t>(e)].truncations;
  }
  EXPECT_GE(terminations, 5);  // both kinds of end occurred
  EXPECT_GE(truncations, 5);
  EXPECT_EQ(envs.faults(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Modes, EveryRow,
                         testing::Combine(testing::Values(Autoreset::kNextStep,
                                                          Autoreset::kSameStep,
                                                          Autoreset::kDisabled),
                                          testing::Values(1, 2, 4),
                                          testing::Values(kEnvs, kEnvs / 3, 1),
                                          testing::Values(Order::kFixed, Order::kArrival)));

TEST(Disabled, SteppingAnEndedEpisodeIsRefusedUntilItsReset) {
  Pool envs(small_env(),
            {.envs = 2, .threads = 1, .autoreset = Autoreset::kDisabled, .seed = kSeed});
  envs.send_reset();
  auto batch = envs.recv();
  std::vector<float> actions(8, 1.0f);  // straight up: both episodes end
  for (int k = 0; batch->status[0] == kRunning || batch->status[1] == kRunning; ++k) {
    ASSERT_LT(k, 20);
    std::vector<std::int32_t> running;
    for (int e = 0; e < 2; ++e) {
      if (batch->status[static_cast<std::size_t>(e)] == kRunning) running.push_back(e);
    }
    if (running.size() < 2) break;
    envs.send(actions);
    batch = envs.recv();
  }
  EXPECT_THROW(envs.send(actions), Error);
  EXPECT_EQ(envs.in_flight(), 0);
  envs.send_reset();
  EXPECT_EQ(envs.recv()->was_reset[0], 1);
  EXPECT_NO_THROW(envs.send(actions));
}

TEST(SameStep, AResetThatIsItselfAFaultShowsInTheNextRowAndIsTriedAgain) {
  Pool envs(small_env(), {.envs = 1, .threads = 1, .autoreset = Autoreset::kSameStep});
  envs.send_reset();
  envs.recv();
  envs.set_param(0, "task.mode", test::kBadReset);
  const std::vector<float> up(4, 1.0f);
  std::shared_ptr<const Batch> batch;
  do {
    envs.send(up);
    batch = envs.recv();
  } while (batch->status[0] == kRunning);
  EXPECT_EQ(batch->fault[0], 0);  // an ordinary end of an episode
  for (int i = 0; i < 2; ++i) {
    envs.send(up);
    batch = envs.recv();
    EXPECT_EQ(batch->was_reset[0], 1);
    EXPECT_EQ(batch->fault[0], 1);
  }
  EXPECT_EQ(envs.faults(), 2u);
  envs.set_param(0, "task.mode", test::kPlain);
  envs.send(up);
  EXPECT_EQ(envs.recv()->fault[0], 0);
  envs.send(up);
  batch = envs.recv();
  EXPECT_EQ(batch->was_reset[0], 0);
  EXPECT_EQ(batch->episode_step[0], 1);
}

}  // namespace
}  // namespace skybody
