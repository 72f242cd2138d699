// Distribution of a round's groups among threads.
#include "core/batch/work_stealing_ranges.h"

#include <gtest/gtest.h>

#include <thread>

namespace skybody {
namespace {

TEST(WorkStealingRanges, AThreadTakesItsOwnRangeFirstAndTheSameInEveryRound) {
  WorkStealingRanges shares(3);
  for (int round = 0; round < 2; ++round) {
    shares.open(10, 3);  // 0-2, 3-5, 6-9
    int first = -1;
    EXPECT_EQ(shares.take(1, first, [](int available) { return available - 1; }), 2);
    EXPECT_EQ(first, 3);
    EXPECT_EQ(shares.take(1, first, [](int available) { return available; }), 1);
    EXPECT_EQ(first, 5);
    EXPECT_EQ(shares.left(), 7);
    // Now from the end of the longest remaining share.
    EXPECT_EQ(shares.take(1, first, [](int) { return 1; }), 1);
    EXPECT_EQ(first, 9);
    while (shares.take(2, first, [](int) { return 1; }) > 0) {
    }
    EXPECT_EQ(shares.left(), 0);
  }
}

TEST(WorkStealingRanges, WithFewerThreadsThanThereAreTheOthersOnlyHelp) {
  WorkStealingRanges shares(4);
  shares.open(5, 1);
  int first = -1;
  EXPECT_EQ(shares.take(3, first, [](int) { return 2; }), 2);
  EXPECT_EQ(first, 3);
  EXPECT_EQ(shares.take(0, first, [](int available) { return available; }), 3);
  EXPECT_EQ(first, 0);
  EXPECT_EQ(shares.take(3, first, [](int) { return 1; }), 0);
}

TEST(WorkStealingRanges, EveryGroupIsTakenOnceByWhateverThreads) {
  constexpr int kGroups = 1000, kThreads = 4, kRounds = 200;
  WorkStealingRanges shares(kThreads);
  std::vector<std::atomic<int>> taken(kGroups);
  std::atomic<int> count{0};
  std::atomic<bool> stop{false};
  const auto work = [&](int thread) {
    int first = 0;
    const int n = shares.take(thread, first, [](int available) { return (available + 1) / 2; });
    for (int k = 0; k < n; ++k) ++taken[static_cast<std::size_t>(first + k)];
    count += n;
  };
  std::vector<std::thread> threads;
  for (int t = 1; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      while (!stop) work(t);
    });
  }
  for (int round = 0; round < kRounds; ++round) {
    count = 0;
    shares.open(kGroups, kThreads);
    while (count < kGroups) work(0);
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  for (const std::atomic<int>& times : taken) ASSERT_EQ(times, kRounds);
}

}  // namespace
}  // namespace skybody
