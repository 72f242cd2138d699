// Rows returned by recv().
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::actions_of;
using test::begin;
using test::gate;
using test::small_env;

std::vector<std::int32_t> ids_of(const Batch& batch) {
  return {batch.env_id.begin(), batch.env_id.begin() + batch.rows};
}

/// Sends the next actions of the environments just received.
void send_back(Pool& envs, const Batch& batch, int k) {
  const std::vector<std::int32_t> ids = ids_of(batch);
  envs.send(actions_of(ids, k, 4), ids);
}

TEST(FixedOrder, GoesRoundAndRoundInOrderOfIds) {
  for (const int threads : {1, 3}) {
    Pool envs(small_env(), {.envs = 7, .batch = 3, .threads = threads});
    envs.send_reset();
    int expected = 0;
    for (int k = 1; k < 40; ++k) {
      const auto batch = envs.recv();
      ASSERT_EQ(batch->rows, 3);
      for (const std::int32_t env : ids_of(*batch)) {
        ASSERT_EQ(env, expected);
        expected = (expected + 1) % 7;
      }
      send_back(envs, *batch, k);
    }
  }
}

TEST(FixedOrder, SkipsThoseThatAreNotInFlight) {
  Pool envs(small_env(), {.envs = 8, .batch = 2, .threads = 2});
  begin(envs);
  envs.send(actions_of({6, 1, 4}, 1, 4), std::vector<std::int32_t>{6, 1, 4});
  EXPECT_EQ(ids_of(*envs.recv()), (std::vector<std::int32_t>{1, 4}));
  envs.send(actions_of({0, 5}, 1, 4), std::vector<std::int32_t>{5, 0});
  // The rotation continues after 4, regardless of the order of sending.
  EXPECT_EQ(ids_of(*envs.recv()), (std::vector<std::int32_t>{5, 6}));
  EXPECT_EQ(ids_of(*envs.recv()), (std::vector<std::int32_t>{0}));
}

TEST(ArrivalOrder, GivesEveryEnvironmentOnceBeforeItIsSentAgain) {
  for (const int threads : {1, 2, 4}) {
    for (const int batch_size : {1, 3, 7}) {
      Pool envs(small_env(),
                {.envs = 7, .batch = batch_size, .threads = threads, .order = Order::kArrival});
      envs.send_reset();
      for (int cycle = 1; cycle < 20; ++cycle) {
        std::vector<std::int32_t> seen;
        while (envs.in_flight() > 0) {
          const auto batch = envs.recv();
          const auto ids = ids_of(*batch);
          seen.insert(seen.end(), ids.begin(), ids.end());
        }
        std::sort(seen.begin(), seen.end());
        ASSERT_EQ(seen, (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6}));
        envs.send(actions_of(seen, cycle, 4));
      }
    }
  }
}

/// Receives until every environment has been received once; sends none of them.
void receive_all(Pool& envs) {
  while (envs.in_flight() > 0) envs.recv();
}

TEST(ArrivalOrder, APartOfALaneGroupIsSteppedIfItsRestIsNotSent) {
  for (const int threads : {1, 2}) {
    Pool envs(small_env(), {.envs = 32, .batch = 11, .threads = threads, .order = Order::kArrival});
    envs.send_reset();
    receive_all(envs);
    const std::vector<std::int32_t> some = {0, 1, 9};
    envs.send(actions_of(some, 1, 4), some);
    EXPECT_EQ(envs.recv()->rows, 3);
  }
}

TEST(ArrivalOrder, NoEnvironmentStarvesWhileOthersFillTheBatches) {
  for (const int threads : {1, 2}) {
    Pool envs(small_env(), {.envs = 32, .batch = 11, .threads = threads, .order = Order::kArrival});
    envs.send_reset();
    receive_all(envs);
    std::vector<std::int32_t> sent;  // without the caller's own 3 ... 7 of the first group
    for (std::int32_t env = 0; env < 32; ++env) {
      if (env < 3 || env > 7) sent.push_back(env);
    }
    envs.send(actions_of(sent, 1, 4), sent);
    std::vector<int> received(32);
    for (int k = 2; k < 100; ++k) {
      const auto batch = envs.recv();
      for (const std::int32_t env : ids_of(*batch)) ++received[static_cast<std::size_t>(env)];
      send_back(envs, *batch, k);
    }
    for (const std::int32_t env : sent) EXPECT_GT(received[static_cast<std::size_t>(env)], 20);
  }
}

TEST(ShortBatch, IsGivenWhereFewerAreInFlight) {
  for (const Order order : {Order::kFixed, Order::kArrival}) {
    Pool envs(small_env(), {.envs = 5, .batch = 5, .threads = 2, .order = order});
    begin(envs);
    const std::vector<std::int32_t> two = {1, 3};
    envs.send(actions_of(two, 1, 4), two);
    EXPECT_EQ(envs.in_flight(), 2);
    const auto batch = envs.recv();
    ASSERT_EQ(batch->rows, 2);
    auto ids = ids_of(*batch);
    std::sort(ids.begin(), ids.end());
    EXPECT_EQ(ids, two);
    EXPECT_EQ(envs.in_flight(), 0);
  }
}

TEST(Send, OfAllAtOnceRunsEachOnceHoweverLateAThreadLeavesItsGroup) {
  for (const int batch_size : {2, 6}) {
    Pool envs(small_env(), {.envs = 6, .batch = batch_size, .threads = 4, .keep_hash = true});
    Pool one(small_env(), {.envs = 6, .threads = 1, .keep_hash = true});
    begin(envs);
    begin(one);
    const std::vector<std::int32_t> all = {0, 1, 2, 3, 4, 5};
    const std::vector<float> actions = actions_of(all, 1, 4);
    for (int k = 0; k < 10000; ++k) {
      // With ids, rows follow the queue, without waiting for all.
      envs.send(actions, all);
      while (envs.in_flight() > 0) envs.recv();
      envs.send(actions);
      while (envs.in_flight() > 0) envs.recv();
      for (int twice = 0; twice < 2; ++twice) {
        one.send(actions);
        one.recv();
      }
      ASSERT_EQ(envs.hash(), one.hash()) << "after " << k;
    }
  }
}

TEST(Recv, WithNothingInFlightIsAnErrorAndNotAHang) {
  Pool envs(small_env(), {.envs = 2, .threads = 2});
  EXPECT_THROW(envs.recv(), Error);
  begin(envs);
  EXPECT_THROW(envs.recv(), Error);
  EXPECT_THROW(envs.recv(std::chrono::milliseconds(1)), Error);
  envs.send_reset(std::vector<std::uint8_t>{0, 0});  // none
  EXPECT_THROW(envs.recv(), Error);
}

TEST(Recv, GivesUpAfterItsPatienceAndLosesNothing) {
  for (const int batch_size : {2, 1}) {
    Pool envs(small_env(), {.envs = 2, .batch = batch_size, .threads = 2});
    begin(envs);
    envs.set_param(1, "task.mode", test::kWait);
    test::ClosedGate closed;
    // The caller passes the gate, a worker waits at it: repeat until a worker has waited.
    const std::vector<std::int32_t> ids = {1};
    for (int k = 1; gate.waiting == 0; ++k) {
      if (envs.in_flight() == 0) envs.send(actions_of({0, 1}, k, 4));
      for (int i = 0; i < 1000 && gate.waiting == 0; ++i) std::this_thread::yield();
      while (envs.in_flight() > 0 && gate.waiting == 0) {
        envs.recv(std::chrono::milliseconds(0));
      }
    }
    while (envs.in_flight() > 1 && envs.recv(std::chrono::milliseconds(1)) != nullptr) {
    }
    const int waiting = envs.in_flight();
    EXPECT_EQ(envs.recv(std::chrono::milliseconds(5)), nullptr);
    EXPECT_EQ(envs.in_flight(), waiting);
    test::ClosedGate::open();
    int rows = 0;
    while (envs.in_flight() > 0) rows += envs.recv(std::chrono::milliseconds::max())->rows;
    EXPECT_EQ(rows, waiting);
  }
}

TEST(ArrivalOrder, OneThatIsStuckDoesNotHoldUpTheOthers) {
  constexpr int kEnvs = 8;
  Pool envs(small_env(), {.envs = kEnvs, .batch = 2, .threads = 2, .order = Order::kArrival});
  begin(envs);
  envs.set_param(0, "task.mode", test::kWait);
  test::ClosedGate closed;
  std::vector<std::int32_t> all(kEnvs);
  for (int e = 0; e < kEnvs; ++e) all[static_cast<std::size_t>(e)] = e;
  envs.send(actions_of(all, 1, 4));
  int k = 2;
  while (gate.waiting == 0) send_back(envs, *envs.recv(), k++);  // until a worker has environment 0
  int others = 0;
  for (int i = 0; i < 200; ++i) {
    const auto batch = envs.recv();
    for (const std::int32_t env : ids_of(*batch)) others += env != 0;
    send_back(envs, *batch, k++);
  }
  EXPECT_GE(others, 399);  // it may have returned once, just before it blocked
  EXPECT_EQ(gate.waiting, 1);
  test::ClosedGate::open();
  bool back = false;
  while (envs.in_flight() > 0) {
    for (const std::int32_t env : ids_of(*envs.recv())) back |= env == 0;
  }
  EXPECT_TRUE(back);
}

TEST(ArrivalOrder, ASlowOneComesBackMoreRarelyThanTheQuickOnes) {
  constexpr int kEnvs = 8;
  Pool envs(small_env(), {.envs = kEnvs, .batch = 1, .threads = 2, .order = Order::kArrival});
  begin(envs);
  envs.set_param(0, "task.mode", test::kSlow);
  std::vector<std::int32_t> all(kEnvs);
  for (int e = 0; e < kEnvs; ++e) all[static_cast<std::size_t>(e)] = e;
  envs.send(actions_of(all, 1, 4));
  int slow = 0, quick = 0;
  for (int k = 2; slow < 20; ++k) {
    const auto batch = envs.recv();
    ++(batch->env_id[0] == 0 ? slow : quick);
    send_back(envs, *batch, k);
  }
  // If the slow one blocked the caller, each of the 7 others would arrive once per slow one.
  EXPECT_GT(quick, 2 * slow * (kEnvs - 1));
}

}  // namespace
}  // namespace skybody
