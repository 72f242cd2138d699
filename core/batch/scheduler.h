// The scheduler of a Pool: tracks environments in flight, the places of their rows, and the batches
// of recv().
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/batch/buffer_ring.h"
#include "core/batch/done_queue.h"
#include "core/batch/environment_states.h"
#include "core/batch/pool.h"
#include "core/batch/thread_pool.h"
#include "core/batch/waiting_lanes.h"

namespace skybody {

/// Rows take one of two paths. A round is a step() of all environments with N_B = N_E: all are sent
/// at once while none is in flight, and workers write directly into the buffer that recv() returns.
/// Otherwise workers write into a staging row per environment, and recv() gathers rows in its
/// order.
///
/// In batches smaller than the pool, in order of arrival, a sent environment waits while the rest
/// of its lane group is finished or running, so that groups are stepped whole. It does not wait if
/// the next batch needs it, or if the caller keeps one of the rest.
class Pool::Scheduler : private GroupRunner {
 public:
  Scheduler(std::shared_ptr<const CompiledScenario> compiled, const PoolOptions& options);

  void send_reset(std::span<const std::uint8_t> mask);
  void send_reset(std::uint64_t seed);
  void send_steps(std::span<const float> actions, std::span<const std::int32_t> env_ids);
  std::shared_ptr<const Batch> recv(ThreadPool::Clock::time_point deadline);

  /// False in a forked child, which has only the caller's thread.
  bool of_this_process() const;
  /// @throws Error in a forked child; a worker's exception
  void check_alive();
  /// @throws Error while environments are in flight
  void check_idle(const char* what);
  void check_id(std::int32_t env) const;
  /// Waits until no thread runs an environment's group, where other environments may be in flight:
  /// the thread that runs a group owns its words and flags.
  void settle(int env);
  bool in_flight(int env) const { return in_flight_[static_cast<std::size_t>(env)] != 0; }

  PoolOptions options;
  EnvironmentStates states;
  int in_flight_count = 0;
  int cursor = 0;  ///< kFixed: the environment whose turn is next
  std::uint64_t faults = 0;
  std::shared_ptr<PoolObserver> observer;  ///< or null

  std::uint64_t fresh_buffers() const { return buffers_.fresh_buffers(); }
  const ThreadPool& threads() const { return threads_; }

 private:
  void run(const int* groups, int count, int thread) override;
  void run_lanes(int group, int thread);
  void send_all_steps(std::span<const float> actions);
  void check_size(std::span<const float> actions, std::size_t count) const;
  void check_steps(std::span<const float> actions, std::span<const std::int32_t> env_ids);
  void check_step(std::int32_t env);
  void unmark(std::span<const std::int32_t> env_ids, std::size_t count);
  void open_round(int count);
  void enqueue(int env);
  void enqueue_all();
  void start(int group, std::uint32_t lanes);
  void start_waiting(int batch);
  bool others_return(int group, std::uint32_t lanes) const;
  void drain();
  std::shared_ptr<const Batch> recv_round(ThreadPool::Clock::time_point deadline);
  void choose_in_turn(int count);
  void choose_oldest(int count);
  bool batch_ready(int count);
  void gather(Batch& out);
  std::shared_ptr<const Batch> finish(Batch& out);

  std::string observer_failure_;  ///< an observer's error that is not yet reported
  std::vector<std::uint8_t> in_flight_, finished_, marked_;
  std::vector<std::int32_t> arrived_;  ///< finished and not yet received, oldest first
  std::vector<std::int32_t> chosen_;   ///< ids of the batch that recv() returns next
  std::vector<std::atomic<std::uint64_t>> group_state_;
  bool waits_ = false;  ///< whether sent environments wait for the rest of their group
  WaitingLanes waiting_;
  BufferRing buffers_;
  Batch staging_;
  Batch* target_ = nullptr;
  bool round_ = false;
  std::atomic<int> round_left_{0};  ///< environments of the round that have not finished
  DoneQueue done_;
  int process_ = 0;     ///< id of the owning process
  ThreadPool threads_;  ///< last: its threads use the other members
};

}  // namespace skybody
