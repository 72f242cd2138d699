// Faults in one environment, in a worker, and in another process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <limits>
#include <numeric>
#include <vector>

#include "core/model/located_error.h"
#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::actions_of;
using test::begin;
using test::small_env;

TEST(NanAction, EndsItsOwnEpisodeAndIsCounted) {
  constexpr int kEnvs = 5;
  const PoolOptions options{.envs = kEnvs, .batch = 2, .threads = 3, .keep_hash = true};
  Pool envs(small_env(), options), untouched(small_env(), options);
  begin(envs);
  begin(untouched);
  for (int k = 1; k < 20; ++k) {
    std::vector<float> actions = actions_of({0, 1, 2, 3, 4}, k, 4);
    untouched.send(actions);
    if (k == 3) actions[2 * 4 + 1] = std::numeric_limits<float>::quiet_NaN();
    envs.send(actions);
    while (envs.in_flight() > 0) {
      const auto batch = envs.recv();
      untouched.recv();
      for (int i = 0; i < batch->rows; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const bool hit = k == 3 && batch->env_id[at] == 2;
        ASSERT_EQ(batch->fault[at], hit);
        if (!hit) continue;
        EXPECT_EQ(batch->status[at], kTruncated | kFault | kBadAction);
        EXPECT_EQ(batch->truncated[at], 1);
        EXPECT_EQ(batch->terminated[at], 0);
        EXPECT_EQ(batch->reward[at], 0.0f);
      }
    }
  }
  EXPECT_EQ(envs.faults(), 1u);
  for (int e = 0; e < kEnvs; ++e) {
    if (e == 2) {
      EXPECT_NE(envs.hash(e), untouched.hash(e));
    } else {
      EXPECT_EQ(envs.hash(e), untouched.hash(e));
    }
  }
}

TEST(Exception, OfAWorkerComesOutOfRecvAndOfEveryLaterCall) {
  for (const int threads : {1, 2, 4}) {
    for (const int batch_size : {6, 2}) {
      for (const Order order : {Order::kFixed, Order::kArrival}) {
        Pool envs(small_env(),
                  {.envs = 6, .batch = batch_size, .threads = threads, .order = order});
        begin(envs);
        envs.set_param(3, "task.mode", test::kThrow);
        envs.send(actions_of({0, 1, 2, 3, 4, 5}, 1, 4));
        const auto receive_all = [&] {
          while (envs.in_flight() > 0) envs.recv();
        };
        const auto thrown =
            testing::ThrowsMessage<LocatedError>(testing::HasSubstr("thrown by the task"));
        EXPECT_THAT(receive_all, thrown);
        EXPECT_THAT([&] { envs.recv(); }, thrown);
        EXPECT_THAT([&] { envs.send(actions_of({0}, 1, 4), std::vector<std::int32_t>{0}); },
                    thrown);
        EXPECT_THAT([&] { envs.send_reset(); }, thrown);
        EXPECT_THAT([&] { envs.save(); }, thrown);
      }
    }
  }
}

TEST(Exception, WhileTheCallerSleepsWakesIt) {
  constexpr int kEnvs = 512;  // enough for a second thread
  Pool envs(small_env(), {.envs = kEnvs, .threads = 2});
  begin(envs);
  for (int e = 0; e < kEnvs; ++e) envs.set_param(e, "task.mode", test::kWait);
  std::vector<std::int32_t> all(kEnvs);
  std::iota(all.begin(), all.end(), 0);
  {
    test::ClosedGate closed;
    envs.send(actions_of(all, 1, 4));
    while (envs.in_flight() > 0 && test::gate.waiting == 0) {
      if (envs.recv(std::chrono::milliseconds(1)) != nullptr) {
        envs.send(actions_of(all, 1, 4));
      }
    }
    std::thread opener([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      test::gate.fail = true;
      test::ClosedGate::open();
    });
    EXPECT_THROW(envs.recv(), LocatedError);
    opener.join();
    test::gate.fail = false;
  }
}

int threads_of_this_process() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/task"))
    ++count;
  return count;
}

int files_of_this_process() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
    ++count;
  return count;
}

/// Joined threads disappear from /proc shortly after join() has returned.
bool threads_come_down_to(int count) {
  for (int i = 0; i < 5000; ++i) {
    if (threads_of_this_process() <= count) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(Destructor, WithWorkUnderWayNeitherHangsNorLeaks) {
  const auto compiled = small_env();
  // ThreadSanitizer starts a thread of its own together with the process's first one.
  { const Pool first(compiled, {.envs = 2, .threads = 2}); }
  const int threads = threads_of_this_process(), files = files_of_this_process();
  for (int i = 0; i < 200; ++i) {
    Pool envs(compiled, {.envs = 5,
                         .batch = 1 + i % 5,
                         .threads = 1 + i % 4,
                         .order = i % 2 == 0 ? Order::kFixed : Order::kArrival,
                         .pin_threads = i % 3 == 0});
    if (i % 8 == 7) continue;  // no action is sent
    envs.send_reset();
    for (int k = 0; k < i % 4; ++k) {
      const auto batch = envs.recv();
      const std::vector<std::int32_t> ids(batch->env_id.begin(),
                                          batch->env_id.begin() + batch->rows);
      envs.send(actions_of(ids, k, 4), ids);
    }
  }
  EXPECT_TRUE(threads_come_down_to(threads));
  EXPECT_EQ(files_of_this_process(), files);
}

TEST(Destructor, LeavesABatchThatIsStillHeld) {
  std::shared_ptr<const Batch> batch;
  {
    Pool envs(small_env(), {.envs = 3, .threads = 2});
    envs.send_reset();
    batch = envs.recv();
  }
  EXPECT_EQ(batch->rows, 3);
  EXPECT_EQ(batch->observation[3 * 2], 1.0f);
}

TEST(Threads, MoreThanProcessorsAndThanEnvironmentsStillWork) {
  Pool envs(small_env(), {.envs = 5, .batch = 2, .threads = 24, .order = Order::kArrival});
  EXPECT_EQ(envs.threads(), 24);
  int rows = 0;
  test::fly(envs, 0, 100, [&](const Batch&, int) { ++rows; });
  EXPECT_EQ(rows, 500);
}

// Neither sanitizer supports these child processes.
#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

/// Runs `body` in a forked child. @returns its exit status, or -1 after a hang
template <class Body>
int in_child(Body&& body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);  // a hang ends with a signal
    _exit(body());
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ProcessFork, CallsInTheChildThrowAndItsDestructorReturns) {
  auto envs = std::make_unique<Pool>(
      small_env(), PoolOptions{.envs = 4, .batch = 2, .threads = 4, .keep_hash = true});
  begin(*envs);
  const auto throws = [&](auto&& call) {
    try {
      call();
    } catch (const Error& error) {
      return std::string(error.what()).find("parent process") != std::string::npos;
    }
    return false;
  };
  const int status = in_child([&] {
    std::vector<float> row(12);
    if (!throws([&] { envs->recv(); })) return 1;
    if (!throws([&] { envs->send(actions_of({0, 1, 2, 3}, 1, 4)); })) return 2;
    if (!throws([&] { envs->send_reset(); })) return 3;
    if (!throws([&] { envs->save(); })) return 4;
    if (!throws([&] { envs->hash(); })) return 5;
    if (!throws([&] { envs->observations(row); })) return 6;
    if (!throws([&] { envs->fork(0, std::vector<std::int32_t>{1}, false); })) return 7;
    envs.reset();
    return 0;
  });
  EXPECT_EQ(status, 0);
  envs->send(actions_of({0, 1, 2, 3}, 1, 4));  // the parent's Pool continues
  EXPECT_EQ(envs->recv()->rows, 2);
}

TEST(ProcessFork, WhileWorkersAreBusyDoesNotHangTheChild) {
  auto envs = std::make_unique<Pool>(
      small_env(), PoolOptions{.envs = 8, .batch = 2, .threads = 4, .order = Order::kArrival});
  begin(*envs);
  for (int i = 0; i < 10; ++i) {
    envs->send(actions_of({0, 1, 2, 3, 4, 5, 6, 7}, i + 1, 4));
    EXPECT_EQ(in_child([&] {
                envs.reset();
                return 0;
              }),
              0);
    while (envs->in_flight() > 0) envs->recv();
  }
}

TEST(Threads, FewerThanAskedForAreAnErrorThatSaysSo) {
  const auto compiled = small_env();
  EXPECT_EQ(in_child([&] {
              const rlimit little{std::uint64_t{1} << 30, std::uint64_t{1} << 30};
              setrlimit(RLIMIT_AS, &little);  // no space for the stacks of a thousand threads
              try {
                Pool envs(compiled, {.envs = 2, .threads = 1024});
              } catch (const Error& error) {
                return std::string(error.what()).find("of 1023 threads") != std::string::npos ? 0
                                                                                              : 1;
              }
              return 2;
            }),
            0);
}

#endif

}  // namespace
}  // namespace skybody
