// Save, restore, fork and new seeds.
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::begin;
using test::fly;
using test::small_env;

PoolOptions options_of(int threads, int batch, Order order = Order::kFixed) {
  return {
      .envs = 6, .batch = batch, .threads = threads, .order = order, .seed = 3, .keep_hash = true};
}

std::vector<std::vector<float>> observations(const Pool& envs) {
  const auto width = static_cast<std::size_t>(envs.compiled().observation_size());
  std::vector<float> flat(width * static_cast<std::size_t>(envs.envs()));
  envs.observations(flat);
  std::vector<std::vector<float>> rows;
  for (auto at = flat.begin(); at != flat.end(); at += static_cast<std::ptrdiff_t>(width)) {
    rows.emplace_back(at, at + static_cast<std::ptrdiff_t>(width));
  }
  return rows;
}

TEST(Restore, InMidEpisodeGivesTheSameFutureWhateverTheThreads) {
  const auto compiled = small_env();
  Pool a(compiled, options_of(2, 2));
  fly(a, 0, 20);
  const auto saved = a.save();
  fly(a, 20, 50);
  const auto future = a.save();
  const std::uint64_t hash = a.hash();

  a.restore(saved);
  fly(a, 20, 50);
  EXPECT_EQ(a.save(), future);
  EXPECT_EQ(a.hash(), hash);
  for (const int threads : {1, 4}) {
    for (const Order order : {Order::kFixed, Order::kArrival}) {
      PoolOptions other = options_of(threads, 3, order);
      other.seed = 77;  // the state contains the keys
      Pool b(compiled, other);
      b.restore(saved);
      fly(b, 20, 50);
      EXPECT_EQ(b.hash(), hash);
    }
  }
}

TEST(Restore, RefusesAStateThatWasChangedAndChangesNothing) {
  Pool envs(small_env(), options_of(2, 2));
  fly(envs, 0, 5);
  const auto saved = envs.save();
  for (const std::size_t word : {saved.size() / 2, saved.size() - 2, saved.size() - 1}) {
    auto changed = saved;
    changed[word] ^= 1u << 20;
    EXPECT_THROW(envs.restore(changed), Error) << "word " << word;
    EXPECT_EQ(envs.save(), saved);
  }
}

TEST(Restore, GoesOnWhereTheOrderWas) {
  const auto compiled = small_env();
  Pool a(compiled, options_of(1, 4)), b(compiled, options_of(2, 4));
  a.send_reset();
  EXPECT_EQ(a.recv()->env_id[0], 0);
  EXPECT_EQ(a.recv()->rows, 2);
  const std::vector<std::int32_t> two = {1, 2};
  a.send(std::vector<float>(8), two);
  a.recv();
  b.restore(a.save());
  for (Pool* envs : {&a, &b}) {
    envs->send(std::vector<float>(24));
    EXPECT_EQ(envs->recv()->env_id[0], 3);
  }
}

TEST(Restore, OfAnEndedEpisodeIntoAnotherAutoresetBeginsTheNext) {
  const auto compiled = small_env();
  Pool disabled(compiled, {.envs = 1, .threads = 1, .autoreset = Autoreset::kDisabled});
  begin(disabled);
  const std::vector<float> up(4, 1.0f);
  std::shared_ptr<const Batch> batch;
  do {
    disabled.send(up);
    batch = disabled.recv();
  } while (batch->status[0] == kRunning);
  for (const Autoreset autoreset : {Autoreset::kNextStep, Autoreset::kSameStep}) {
    Pool envs(compiled, {.envs = 1, .threads = 1, .autoreset = autoreset});
    envs.restore(disabled.save());
    envs.send(up);
    batch = envs.recv();
    EXPECT_EQ(batch->was_reset[0], 1);
    EXPECT_EQ(batch->episode_step[0], 0);
  }
}

TEST(Restore, RefusesWhatDoesNotFit) {
  Pool envs(small_env(), options_of(1, 2));
  PoolOptions five = options_of(1, 2);
  five.envs = 5;
  Pool fewer(small_env(), five);
  begin(envs);
  const auto saved = envs.save();
  EXPECT_THROW(fewer.restore(saved), Error);
  EXPECT_THROW(envs.restore({}), Error);
  EXPECT_THROW(envs.restore(std::vector<std::uint64_t>(saved.size())), Error);
  EXPECT_THROW(envs.restore(std::span(saved).first(saved.size() - 3)), Error);
  EXPECT_THROW(envs.restore(std::span(saved).first(3)), Error);
  EXPECT_EQ(envs.save(), saved);
}

TEST(Fork, CopiesHaveTheSameFuture) {
  Pool envs(small_env(), options_of(2, 6));
  fly(envs, 0, 7);
  envs.fork(1, std::vector<std::int32_t>{0, 4}, false);
  EXPECT_EQ(envs.hash(4), envs.hash(1));
  const std::uint64_t other = envs.hash(2);
  for (int k = 0; k < 40; ++k) {  // several episodes, all with the same actions
    envs.send(std::vector<float>(24, 0.4f));
    envs.recv();
  }
  EXPECT_EQ(envs.hash(0), envs.hash(1));
  EXPECT_EQ(envs.hash(4), envs.hash(1));
  EXPECT_NE(envs.hash(2), envs.hash(1));
  EXPECT_NE(envs.hash(2), other);
}

TEST(Fork, RekeyedCopiesDifferFromTheNextEpisodeOnAndReproducibly) {
  const auto compiled = small_env();
  std::vector<std::vector<float>> rows[2];
  for (int run = 0; run < 2; ++run) {
    Pool envs(compiled, options_of(1 + 3 * run, 6));
    fly(envs, 0, 7);
    Pool parent(compiled, options_of(1, 6));
    parent.restore(envs.save());
    envs.fork(1, std::vector<std::int32_t>{0, 2, 3}, true);
    auto now = observations(envs);
    EXPECT_EQ(now[0], now[1]);  // equal motion so far
    EXPECT_EQ(now[3], now[1]);
    for (Pool* each : {&envs, &parent}) {
      each->send_reset();
      while (each->in_flight() > 0) each->recv();
    }
    now = rows[run] = observations(envs);
    EXPECT_NE(now[0], now[1]);
    EXPECT_NE(now[2], now[1]);
    EXPECT_NE(now[3], now[1]);
    EXPECT_NE(now[0], now[2]);
    EXPECT_NE(now[0], now[3]);
    EXPECT_NE(now[2], now[3]);
    EXPECT_EQ(now[1], observations(parent)[1]);  // the source's future is unchanged
    EXPECT_EQ(now[5], observations(parent)[5]);
  }
  EXPECT_EQ(rows[0], rows[1]);
}

TEST(Seed, AResetUnderASeedIsThatOfANewPool) {
  const auto compiled = small_env();
  Pool used(compiled, options_of(2, 6)), fresh(compiled, options_of(2, 6));
  fly(used, 0, 30);
  used.set_param(2, "task.mode", test::kSlow);
  begin(fresh);
  used.send_reset(std::uint64_t{3});
  while (used.in_flight() > 0) used.recv();
  EXPECT_EQ(observations(used), observations(fresh));
  EXPECT_EQ(used.param(2, "task.mode"), 0.0);
  for (Pool* envs : {&used, &fresh}) fly(*envs, 1, 30);  // episode counters are equal as well
  EXPECT_EQ(observations(used), observations(fresh));
  used.send_reset(std::uint64_t{4});
  while (used.in_flight() > 0) used.recv();
  begin(fresh);
  EXPECT_NE(observations(used), observations(fresh));
  EXPECT_EQ(used.options().seed, 4u);
}

TEST(Params, AreOfOneEnvironment) {
  Pool envs(small_env(), options_of(1, 6));
  begin(envs);
  const std::string mass = "robots.quad.links.base.mass";
  envs.set_param(4, mass, 2.0);
  EXPECT_EQ(envs.param(4, mass), 2.0);
  EXPECT_EQ(envs.param(3, mass), 1.0);
  envs.send(std::vector<float>(24, 0.4f));
  envs.recv();
  const auto rows = observations(envs);
  EXPECT_LT(rows[4][1], rows[3][1] + 0.2f);  // heavier: climbs more slowly, for every initial speed
}

/// Environments of a group share memory words: a fork must not race with a thread that steps a
/// neighbour.
TEST(Fork, WhileNeighboursAreInFlightCopiesAllTheSame) {
  Pool envs(small_env(), {.envs = 16, .batch = 4, .threads = 2, .order = Order::kArrival});
  ASSERT_GT(envs.lanes(), 1);
  begin(envs);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::int32_t> all(16);
    std::iota(all.begin(), all.end(), 0);
    envs.send(test::actions_of(all, round, 4), all);
    const auto batch = envs.recv();
    const std::int32_t source = batch->env_id[0], target = batch->env_id[3];
    envs.fork(source, {&target, 1}, false);
    while (envs.in_flight() > 0) envs.recv();
    std::vector<double> height(16 * 3);
    envs.state("robots.quad.base.position", height);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(height[static_cast<std::size_t>(3 * target + k)],
                height[static_cast<std::size_t>(3 * source + k)]);
    }
  }
}

}  // namespace
}  // namespace skybody
