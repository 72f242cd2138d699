// The threads of a Pool or a SimulationPool: workers that take groups from a queue, and the caller,
// which works too.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/simd/fp_environment.h"
#include "core/batch/work_queue.h"
#include "core/batch/work_stealing_ranges.h"

namespace skybody {

/// Runs groups. Called from any thread of the pool, never by two at a time for one group.
class GroupRunner {
 public:
  virtual ~GroupRunner() = default;
  /// @param thread  index of the calling thread: 0 is the caller's
  virtual void run(const int* groups, int count, int thread) = 0;
};

/// N_T threads including the caller. Clocks are read for scheduling only: they affect the
/// assignment of work to threads, never the results.
///
/// The amount of work that a thread takes at once depends on the measured cost of steps: about 20
/// us, less if little is left, and one group at a time if groups are slow. A group that is far
/// slower than the others is left to the workers while faster ones wait or run, so that it does not
/// delay the caller. In a round, all of which the caller waits for, every thread begins with a
/// range of its own (WorkStealingRanges). Work of a few microseconds stays with the caller. Idle
/// workers spin for a bounded time, then sleep.
class ThreadPool {
 public:
  using Clock = std::chrono::steady_clock;

  /// @throws Error if the system provides fewer threads
  ThreadPool(int threads, int groups, bool pin, GroupRunner& runner);
  /// Workers finish the groups that they have taken; waiting groups are dropped.
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Adds a group to the next submit(). For the caller only.
  void add(int group);
  /// Makes the added groups visible to the threads.
  void submit();
  /// Submits all groups at once. None may be waiting or running; the caller waits for all of them.
  void submit_round();
  /// Submits groups 0 to `count` - 1 at once. None may be waiting or running. Their cost is
  /// unknown, since the work differs from call to call: all threads are woken, and each takes a
  /// quarter of the rest of its range.
  void submit_unknown(int count);

  /// The caller works and waits until `done()` holds. @returns false on expiry of the deadline
  /// @throws a worker's exception
  template <class Done>
  bool wait(Done&& done, Clock::time_point deadline) {
    const FpEnvironment guard;  // the caller's mode is its own; workers set theirs once
    for (int idle = 0; !done();) {
      rethrow_failure();
      if (help()) {
        idle = 0;
        if (Clock::now() >= deadline && !done()) return false;
      } else if (++idle < spin_limit_) {
        pause();
      } else {
        if (Clock::now() >= deadline) return false;
        sleep_until(deadline, done);
        idle = 0;
      }
    }
    rethrow_failure();
    return true;
  }

  /// Wakes the caller after something has finished. Called by the runner, after it has made the
  /// result visible.
  void announce() {
    if (caller_sleeps_.load(std::memory_order_seq_cst)) wake_caller();
  }

  /// @throws the first exception of a worker
  void rethrow_failure();
  bool failed() const { return failed_.load(std::memory_order_acquire); }

  int threads() const { return static_cast<int>(workers_.size()) + 1; }
  int pinned() const { return pinned_; }

 private:
  static void pause() {
#ifdef __SSE2__
    __builtin_ia32_pause();
#else
    std::this_thread::yield();
#endif
  }

  template <class Done>
  void sleep_until(Clock::time_point deadline, Done&& done) {
    std::unique_lock lock(mutex_);
    caller_sleeps_.store(true, std::memory_order_seq_cst);
    const auto awake = [&] {
      return done() || failed_.load() || (quick_running_.load() == 0 && !queue_.empty());
    };
    caller_wakes_.wait_until(lock, deadline, awake);
    caller_sleeps_.store(false, std::memory_order_relaxed);
  }

  bool has_work() const { return !queue_.empty() || shares_.left() > 0; }
  int threads_worth(double waiting) const;
  void open_shares(int groups, int wanted, bool costs_are_known);
  void start_workers(int count);
  void dismiss_workers();
  void work(int index);
  bool help();
  bool run_block(int thread);
  bool run_share(int thread);
  void run_taken(const int* groups, int count, int thread, bool takes_time);
  bool is_slow(int group) const;
  void leave_to_workers(int group);
  void want_all();
  double usual_cost() const;
  int choose(const int* groups, int available) const;
  int choose_share(int available) const;
  void note_cost(const int* groups, int count, double seconds);
  double expected_cost(int group) const;
  void wake_workers();
  void sleep(int index);
  void wake_caller();
  void fail(std::exception_ptr error);
  void pin_worker(int index);

  GroupRunner& runner_;
  int groups_ = 0;
  WorkQueue queue_;
  WorkStealingRanges shares_;
  std::vector<std::atomic<float>>
      cost_;  ///< cost of a group's last runs, without rounds on workers [s]; 0: unknown
  std::atomic<float> mean_cost_{0.0f};  ///< the same, over all groups
  double added_cost_ = 0.0;             ///< expected cost of groups added and not yet submitted
  int spin_limit_ = 0;

  std::atomic<bool> costs_are_known_{true};  ///< in the current round
  std::atomic<int> wanted_{1};  ///< number of threads that should work now, including the caller
  std::atomic<int> sleepers_{0};
  std::atomic<int> quick_running_{0};  ///< workers that run groups which are not slow
  std::atomic<bool> stop_{false}, failed_{false}, caller_sleeps_{false};
  std::exception_ptr failure_;
  std::mutex mutex_;
  std::condition_variable workers_wake_, caller_wakes_;
  int pinned_ = 0;
  std::vector<std::thread> workers_;
};

}  // namespace skybody
