#include "core/batch/thread_pool.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/simd/fp_environment.h"
#include "core/base/system/error.h"
#include "core/base/system/processors.h"

namespace skybody {
namespace {

constexpr int kMostGroups = 64;          // groups per block
constexpr double kBlock = 20e-6;         // expected cost of a full block [s]
constexpr double kSmallestBlock = 2e-6;  // large enough that a claim is cheap beside it [s]
constexpr double kSmallestShare = 4e-6;  // in a round, where threads' claims collide [s]
constexpr double kCallerAlone = 10e-6;   // waking a thread costs about as much [s]
constexpr double kAwakeAlone = 3e-6;     // not worth sharing with an awake thread [s]
constexpr double kUnknownCost = 10e-6;   // of a group that never ran [s]
constexpr double kSlow = 8.0;            // times the mean cost: left to the workers
constexpr int kSpins = 2000;             // pauses, about 50 us

float smooth(float old, float now) { return old == 0.0f ? now : 0.75f * old + 0.25f * now; }

}  // namespace

ThreadPool::ThreadPool(int threads, int groups, bool pin, GroupRunner& runner)
    : runner_(runner),
      groups_(groups),
      queue_(groups),
      shares_(threads),
      cost_(static_cast<std::size_t>(groups)) {
  const auto processors = static_cast<int>(allowed_processors().size());
  spin_limit_ = threads <= processors ? kSpins : 1;  // else spinning steals time
  start_workers(threads - 1);
  if (pin) {
    for (int k = 1; k < threads; ++k) pin_worker(k);
  }
}

ThreadPool::~ThreadPool() { dismiss_workers(); }

void ThreadPool::start_workers(int count) {
  workers_.reserve(static_cast<std::size_t>(count));
  try {
    for (int k = 1; k <= count; ++k) workers_.emplace_back([this, k] { work(k); });
  } catch (const std::system_error& error) {
    const std::size_t started = workers_.size();
    dismiss_workers();
    throw Error("the system gave " + std::to_string(started) + " of " + std::to_string(count) +
                " threads (" + error.what() + "): take fewer threads, or raise its limit");
  }
}

void ThreadPool::dismiss_workers() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  workers_wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

/// Pins each worker to a processor of its own; the first allowed one is left to the caller. If the
/// system refuses, the worker is not pinned.
void ThreadPool::pin_worker(int index) {
  const std::vector<int> processors = allowed_processors();
  if (static_cast<std::size_t>(index) >= processors.size()) return;
  std::thread& worker = workers_[static_cast<std::size_t>(index) - 1];
  if (pin_thread(worker, processors[static_cast<std::size_t>(index)])) ++pinned_;
}

double ThreadPool::expected_cost(int group) const {
  const float own = cost_[static_cast<std::size_t>(group)].load(std::memory_order_relaxed);
  return own > 0.0f ? static_cast<double>(own) : kUnknownCost;
}

void ThreadPool::add(int group) {
  queue_.push(group);
  added_cost_ += expected_cost(group);
}

void ThreadPool::submit() {
  const double waiting = added_cost_ + static_cast<double>(queue_.size()) * usual_cost();
  wanted_.store(threads_worth(waiting), std::memory_order_relaxed);
  added_cost_ = 0.0;
  queue_.publish();
  if (wanted_.load(std::memory_order_relaxed) > 1) wake_workers();
}

void ThreadPool::submit_round() {
  const int wanted = std::min(threads_worth(groups_ * usual_cost()), groups_);
  open_shares(groups_, wanted, true);
}

void ThreadPool::submit_unknown(int count) {
  open_shares(count, std::min(threads(), count), false);
}

void ThreadPool::open_shares(int groups, int wanted, bool costs_are_known) {
  wanted_.store(wanted, std::memory_order_relaxed);
  costs_are_known_.store(costs_are_known, std::memory_order_relaxed);
  shares_.open(groups, wanted);
  if (wanted > 1) wake_workers();
}

/// Number of threads that are worthwhile for work of that cost [s].
int ThreadPool::threads_worth(double waiting) const {
  const bool all_awake = sleepers_.load(std::memory_order_relaxed) == 0;
  const double alone = all_awake ? kAwakeAlone : kCallerAlone;
  return std::min(threads(), 1 + static_cast<int>(std::min(waiting / alone, 1e6)));
}

void ThreadPool::wake_workers() {
  if (sleepers_.load(std::memory_order_seq_cst) == 0) return;
  const std::lock_guard lock(mutex_);
  workers_wake_.notify_all();
}

void ThreadPool::work(int index) {
  const FpEnvironment guard;
  int idle = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    if (index < wanted_.load(std::memory_order_relaxed) && run_block(index)) {
      idle = 0;
    } else if (++idle < spin_limit_) {
      pause();
    } else {
      sleep(index);
      idle = 0;
    }
  }
}

void ThreadPool::sleep(int index) {
  std::unique_lock lock(mutex_);
  sleepers_.fetch_add(1, std::memory_order_seq_cst);
  workers_wake_.wait(lock, [&] { return stop_.load() || (has_work() && index < wanted_.load()); });
  sleepers_.fetch_sub(1, std::memory_order_relaxed);
}

void ThreadPool::wake_caller() {
  const std::lock_guard lock(mutex_);
  caller_wakes_.notify_one();
}

bool ThreadPool::is_slow(int group) const {
  const double mean = static_cast<double>(mean_cost_.load(std::memory_order_relaxed));
  return mean > 0.0 && expected_cost(group) > std::max(kSlow * mean, kBlock);
}

/// One block of work by a worker. @returns false if no group waits
bool ThreadPool::run_block(int thread) {
  if (run_share(thread)) return true;
  int groups[kMostGroups];
  const int count = queue_.take(groups, kMostGroups, [&](const int* first, int available) {
    return choose(first, available);
  });
  if (count == 0) return false;
  const bool quick = !is_slow(groups[0]);
  if (quick) quick_running_.fetch_add(1, std::memory_order_seq_cst);
  run_taken(groups, count, thread, true);
  if (quick && quick_running_.fetch_sub(1, std::memory_order_seq_cst) == 1) announce();
  return true;
}

/// One block of a round, on any thread. The caller takes slow groups of a round, too. Costs are
/// measured on the caller only, since threads that write to the same places delay one another.
/// @returns false if no group of the round is left
bool ThreadPool::run_share(int thread) {
  int groups[kMostGroups];
  int first = 0;
  const int count =
      shares_.take(thread, first, [&](int available) { return choose_share(available); });
  if (count == 0) return false;
  std::iota(groups, groups + count, first);
  run_taken(groups, count, thread, thread == 0 && costs_are_known_.load(std::memory_order_relaxed));
  return true;
}

/// One block by the caller. Like a worker's, but a slow group must not delay the caller while
/// faster ones wait (the slow one goes to the end of the queue) or run (it is left in place).
/// @returns false if the caller has nothing to do
bool ThreadPool::help() {
  if (run_share(0)) return true;
  int groups[kMostGroups];
  bool defer = false, leave = false;
  const int count = queue_.take(groups, kMostGroups, [&](const int* first, int available) {
    const bool slow = !workers_.empty() && is_slow(*first);
    defer = slow && std::any_of(first + 1, first + available, [&](int g) { return !is_slow(g); });
    leave = slow && !defer && quick_running_.load(std::memory_order_relaxed) > 0;
    if (leave) return 0;
    return defer ? 1 : choose(first, available);
  });
  if (count == 0) {
    if (leave) want_all();
    return false;
  }
  if (defer) {
    leave_to_workers(groups[0]);
  } else {
    run_taken(groups, count, 0, true);
  }
  return true;
}

void ThreadPool::run_taken(const int* groups, int count, int thread, bool takes_time) {
  try {
    if (!takes_time || groups_ == 1) return runner_.run(groups, count, thread);
    const Clock::time_point start = Clock::now();
    runner_.run(groups, count, thread);
    note_cost(groups, count, std::chrono::duration<double>(Clock::now() - start).count());
  } catch (...) {
    fail(std::current_exception());
  }
}

void ThreadPool::leave_to_workers(int group) {
  wanted_.store(threads(), std::memory_order_relaxed);
  queue_.push(group);
  queue_.publish();
  wake_workers();
}

/// Wakes all workers, even if submit() decided on fewer.
void ThreadPool::want_all() {
  if (wanted_.exchange(threads(), std::memory_order_seq_cst) != threads()) wake_workers();
}

/// Estimated cost of a group without its own measurement [s].
double ThreadPool::usual_cost() const {
  const float mean = mean_cost_.load(std::memory_order_relaxed);
  return mean > 0.0f ? static_cast<double>(mean) : kUnknownCost;
}

/// Number of groups to take from a range: half of it, so that others may help at its end. Bounded
/// below, so that claims stay cheap, and above, so that slow groups do not wait long.
int ThreadPool::choose_share(int available) const {
  if (!costs_are_known_.load(std::memory_order_relaxed)) {
    return std::min((available + 3) / 4, kMostGroups);
  }
  const int few = std::max(static_cast<int>(kSmallestShare / usual_cost()), 1);
  const int many = std::max(static_cast<int>(kBlock / usual_cost()), few);
  const int wanted = workers_.empty() ? many : std::clamp((available + 1) / 2, few, many);
  return std::min({wanted, available, kMostGroups});
}

/// Number of waiting groups to take.
int ThreadPool::choose(const int* groups, int available) const {
  const double waiting = static_cast<double>(queue_.size()) * usual_cost();
  const double share = waiting / (2.0 * wanted_.load(std::memory_order_relaxed));
  const double budget = workers_.empty() ? kBlock : std::clamp(share, kSmallestBlock, kBlock);
  double cost = expected_cost(groups[0]);
  int count = 1;
  while (count < available && (cost += expected_cost(groups[count])) <= budget) ++count;
  return count;
}

void ThreadPool::note_cost(const int* groups, int count, double seconds) {
  const auto each = static_cast<float>(seconds / count);
  for (int k = 0; k < count; ++k) {
    std::atomic<float>& cost = cost_[static_cast<std::size_t>(groups[k])];
    cost.store(smooth(cost.load(std::memory_order_relaxed), each), std::memory_order_relaxed);
  }
  // A slow group moves the mean by at most a quarter; otherwise it would no longer count as slow.
  const float mean = mean_cost_.load(std::memory_order_relaxed);
  mean_cost_.store(smooth(mean, mean > 0.0f ? std::min(each, 2.0f * mean) : each),
                   std::memory_order_relaxed);
}

void ThreadPool::fail(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  if (!failed_) failure_ = std::move(error);
  failed_ = true;
  caller_wakes_.notify_one();
}

void ThreadPool::rethrow_failure() {
  if (!failed_.load(std::memory_order_acquire)) return;
  const std::lock_guard lock(mutex_);
  std::rethrow_exception(failure_);
}

}  // namespace skybody
