// The threads of a learner. They run the tasks of a phase, and the calling thread takes part.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <type_traits>

#include "core/batch/thread_pool.h"

namespace skybody::learn {

/// A ThreadPool for phases of learning: run() executes some tasks at once and waits for all of
/// them. While a task runs, its thread flushes denormal numbers to zero. They arise in gradients of
/// saturated units, are negligible there, and cost a processor a hundred times the time of other
/// numbers. (A Pool stepped by a task sets the standard mode for itself.)
class LearnerThreads : private GroupRunner {
 public:
  /// @param threads     including the caller; 0: one per processor that the process may use
  /// @param most_tasks  largest `count` of run(); no more threads than that are started
  LearnerThreads(int threads, int most_tasks);

  int threads() const { return threads_.threads(); }

  /// Calls work(task, thread) once for each task 0 ... count - 1, on any thread, and returns when
  /// all have ended. Does not allocate.
  /// @throws the exception of a task, after the others have ended
  template <class Work>
  void run(int count, Work&& work) {
    context_ = const_cast<void*>(static_cast<const void*>(&work));
    call_ = [](void* context, int task, int thread) {
      (*static_cast<std::remove_reference_t<Work>*>(context))(task, thread);
    };
    run_tasks(count);
  }

 private:
  void run(const int* tasks, int count, int thread) override;
  void run_tasks(int count);
  void keep_failure();

  void* context_ = nullptr;
  void (*call_)(void* context, int task, int thread) = nullptr;
  std::atomic<int> left_{0};
  std::mutex mutex_;
  std::exception_ptr failure_;
  ThreadPool threads_;  // last: its threads end before the members they use
};

}  // namespace skybody::learn
