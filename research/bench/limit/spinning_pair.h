// Two threads that share each round of work and wait for one another by spinning; the caller is one
// of them. The fastest way to use two processors without other load.
#pragma once

#include <emmintrin.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "core/base/system/processors.h"

namespace skybody::bench::limit {

/// Pins the calling thread to one of its allowed processors, by index in their list.
inline void pin_this_thread(std::size_t place) {
  const std::vector<int> processors = allowed_processors();
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(processors[place % processors.size()], &set);
  pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
}

/// During its lifetime, the caller is pinned to the first processor and its companion to the
/// second.
class SpinningPair {
 public:
  /// @param work  called with 0 on the caller's thread and 1 on the companion's, every round
  explicit SpinningPair(std::function<void(int)> work) : work_(std::move(work)) {
    sched_getaffinity(0, sizeof(before_), &before_);
    companion_ = std::thread([this] { follow(); });
    pin_this_thread(0);
  }
  ~SpinningPair() {
    round_.store(kStop, std::memory_order_release);
    companion_.join();
    sched_setaffinity(0, sizeof(before_), &before_);
  }
  SpinningPair(const SpinningPair&) = delete;
  SpinningPair& operator=(const SpinningPair&) = delete;

  /// Runs both shares of a round.
  void run() {
    const std::uint64_t round = round_.load(std::memory_order_relaxed) + 1;
    round_.store(round, std::memory_order_release);
    work_(0);
    while (done_.load(std::memory_order_acquire) != round) _mm_pause();
  }

 private:
  static constexpr std::uint64_t kStop = ~std::uint64_t{0};

  void follow() {
    pin_this_thread(1);
    for (std::uint64_t last = 0;;) {
      std::uint64_t round;
      while ((round = round_.load(std::memory_order_acquire)) == last) _mm_pause();
      if (round == kStop) return;
      work_(1);
      done_.store(round, std::memory_order_release);
      last = round;
    }
  }

  std::function<void(int)> work_;
  cpu_set_t before_;
  alignas(64) std::atomic<std::uint64_t> round_{0};
  alignas(64) std::atomic<std::uint64_t> done_{0};
  std::thread companion_;
};

}  // namespace skybody::bench::limit
