// A Pool for Python: one thread at a time, without the GIL, closable.
#pragma once

#include <nanobind/nanobind.h>
#include <sys/types.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/batch/pool.h"
#include "core/replay/replay_recorder.h"
#include "python/native/errors.h"
#include "python/native/exclusive.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

class PythonPool {
 public:
  /// @throws ValueError if an option is out of range
  PythonPool(const LoadedScenario& compiled, const PoolOptions& options);
  ~PythonPool();
  PythonPool(const PythonPool&) = delete;
  PythonPool& operator=(const PythonPool&) = delete;

  /// Calls work(Pool&) exclusively and without the GIL.
  /// @throws Error if closed, in use by another thread, or made before a fork()
  template <class Work>
  decltype(auto) call(Work&& work) {
    const Exclusive alone(in_use_, "pool");
    Pool& pool = open();
    const nb::gil_scoped_release release;
    return std::forward<Work>(work)(pool);
  }

  /// The same, where any refusal by the Pool is an error of an argument: ValueError.
  template <class Work>
  decltype(auto) call_with_argument(Work&& work) {
    const Exclusive alone(in_use_, "pool");
    Pool& pool = open();
    const nb::gil_scoped_release release;
    return with_argument(pool, std::forward<Work>(work));
  }

  /// Sends actions. @param env_ids  empty: all environments in order
  /// @throws ValueError as Pool::send()
  void send(std::span<const float> actions, std::span<const std::int32_t> env_ids = {});

  /// Waits for a batch; signals (KeyboardInterrupt) are handled.
  /// @throws ValueError if nothing is in flight; any error of a worker
  std::shared_ptr<const Batch> recv();

  /// One transition of all environments: send() and recv() in one call.
  /// @throws Error if an interrupted step is pending; as send() and recv()
  std::shared_ptr<const Batch> step(std::span<const float> actions);
  /// For each row of a batch the number of values beyond [-1, 1] in the action that led to it.
  /// Empty if there are none.
  std::vector<std::int32_t> clipped(const Batch& batch) const;
  /// Total number of these in all sent actions.
  std::uint64_t all_clipped() const { return all_clipped_; }
  /// @throws Error if a step was interrupted and its transitions are pending
  void refuse_interrupted() { call(check_not_interrupted); }

  /// Records all further events to a file, for `skybody replay`.
  /// @throws Error if already recording or in flight, or if the file cannot be written
  void record(const std::filesystem::path& file, bool states);
  /// @throws Error if there is no recording, or the file cannot be finished
  void stop_recording();

  /// Finishes a recording and stops the workers after their current steps. May be called again.
  /// @throws Error if the recording cannot be finished; the pool is closed all the same
  void close();
  bool closed() const { return pool_ == nullptr; }

  const LoadedScenario& compiled() const { return compiled_; }
  int envs() const { return envs_; }
  int batch() const { return batch_; }
  int threads() const { return threads_; }
  int pinned_threads() const { return pinned_threads_; }

 private:
  Pool& open() const;
  template <class Work>
  static decltype(auto) with_argument(Pool& pool, Work&& work) {
    if (pool.broken()) return std::forward<Work>(work)(pool);  // throws the worker's error
    return rethrow_as_argument_error(
        [&]() -> decltype(auto) { return std::forward<Work>(work)(pool); });
  }
  static void check_not_interrupted(const Pool& pool);
  static std::shared_ptr<const Batch> receive(Pool& pool);
  void count_clipped(std::span<const float> actions, std::span<const std::int32_t> env_ids);
  bool of_this_process() const;
  void finish_recording();
  void let_go();

  LoadedScenario compiled_;
  std::shared_ptr<ReplayRecorder> recorder_;  ///< the Pool's observer
  std::unique_ptr<Pool> pool_;
  std::atomic<bool> in_use_ = false;
  int process_;
  std::vector<std::int32_t> clipped_;  ///< per environment, of its last action; empty: none so far
  std::uint64_t all_clipped_ = 0;
  int envs_ = 0, batch_ = 0, threads_ = 0, pinned_threads_ = 0;
};

}  // namespace skybody::python
