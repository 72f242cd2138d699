#include "learn/common/learner_threads.h"

#include <algorithm>
#include <utility>

#include "core/base/system/processors.h"
#include "learn/common/flushed_denormals.h"

namespace skybody::learn {
namespace {

int threads_for(int wanted, int most_tasks) {
  const int there = wanted > 0 ? wanted : static_cast<int>(allowed_processors().size());
  return std::clamp(there, 1, most_tasks);
}

}  // namespace

LearnerThreads::LearnerThreads(int threads, int most_tasks)
    : threads_(threads_for(threads, most_tasks), most_tasks, false, *this) {}

void LearnerThreads::run_tasks(int count) {
  left_.store(count, std::memory_order_relaxed);
  threads_.submit_unknown(count);
  threads_.wait([this] { return left_.load(std::memory_order_acquire) == 0; },
                ThreadPool::Clock::time_point::max());
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void LearnerThreads::run(const int* tasks, int count, int thread) {
  const FlushedDenormals guard;
  for (int k = 0; k < count; ++k) {
    try {
      call_(context_, tasks[k], thread);
    } catch (...) {
      keep_failure();
    }
    left_.fetch_sub(1, std::memory_order_acq_rel);
  }
  threads_.announce();
}

/// Keeps the first failure only; later ones are usually its consequences.
void LearnerThreads::keep_failure() {
  const std::lock_guard lock(mutex_);
  if (!failure_) failure_ = std::current_exception();
}

}  // namespace skybody::learn
