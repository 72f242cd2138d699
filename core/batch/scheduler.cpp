#include "core/batch/scheduler.h"

#include <algorithm>
#include <bit>
#include <exception>
#include <numeric>
#include <string>
#include <utility>

#include "core/base/system/arguments.h"
#include "core/base/system/error.h"
#include "core/base/system/process_id.h"
#include "core/base/system/processors.h"

namespace skybody {
namespace {

// A group's state: the lanes that wait to be run, and whether the group is owned by a thread or
// queued for one.
constexpr std::uint64_t kLaneBits = 0xffffffffu;
constexpr std::uint64_t kOwned = std::uint64_t{1} << 32;

int threads_for(const PoolOptions& options) {
  if (options.threads > 0) return options.threads;
  return std::min(static_cast<int>(allowed_processors().size()), options.envs);
}

PoolOptions completed(PoolOptions options) {
  if (options.batch == 0) options.batch = options.envs;
  options.threads = threads_for(options);
  return options;
}

}  // namespace

Pool::Scheduler::Scheduler(std::shared_ptr<const CompiledScenario> compiled,
                           const PoolOptions& given)
    : options(completed(given)),
      states(std::move(compiled), options),
      in_flight_(static_cast<std::size_t>(options.envs)),
      finished_(in_flight_.size()),
      marked_(in_flight_.size()),
      group_state_(static_cast<std::size_t>(states.places().count())),
      waits_(options.order == Order::kArrival && options.batch < options.envs &&
             states.places().span > 1),
      waiting_(states.places().count()),
      buffers_(options.batch, states.widths(), options.autoreset == Autoreset::kSameStep,
               options.debug_buffers),
      staging_(options.envs, states.widths(), options.autoreset == Autoreset::kSameStep),
      done_(options.envs),
      process_(process_id()),
      threads_(options.threads, states.places().count(), options.pin_threads, *this) {
  arrived_.reserve(in_flight_.size());
  chosen_.reserve(in_flight_.size());
  std::iota(staging_.env_id.begin(), staging_.env_id.end(), 0);
}

bool Pool::Scheduler::of_this_process() const { return process_ == process_id(); }

void Pool::Scheduler::check_alive() {
  if (!of_this_process()) {
    throw StateError(
        "this Pool belongs to the parent process: its threads did not come along with the fork. "
        "Make one in the child, or start processes by `spawn`");
  }
  threads_.rethrow_failure();
  if (!observer_failure_.empty()) throw StateError(std::exchange(observer_failure_, {}));
}

void Pool::Scheduler::check_idle(const char* what) {
  check_alive();
  if (in_flight_count == 0) return;
  throw StateError(std::string(what) + " while " + std::to_string(in_flight_count) +
                   " environments are in flight: recv() them first");
}

void Pool::Scheduler::check_id(std::int32_t env) const {
  check_index("environment", env, states.envs());
}

void Pool::Scheduler::settle(int env) {
  const std::atomic<std::uint64_t>& state =
      group_state_[static_cast<std::size_t>(states.places().group_of(env))];
  threads_.wait([&] { return state.load(std::memory_order_acquire) == 0; },
                ThreadPool::Clock::time_point::max());
}

void Pool::Scheduler::send_reset(std::span<const std::uint8_t> mask) {
  check_alive();
  int count = 0;
  for (int env = 0; env < states.envs(); ++env) {
    if (mask[static_cast<std::size_t>(env)] == 0) continue;
    ++count;
    if (in_flight(env)) {
      throw Error("environment " + std::to_string(env) +
                  " is to be reset while it is in flight: recv() it first");
    }
  }
  open_round(count);
  for (int env = 0; env < states.envs(); ++env) {
    if (mask[static_cast<std::size_t>(env)] == 0) continue;
    states.flags().want_reset(env);
    states.requests().hand_over(env);
    enqueue(env);
  }
  start_waiting(options.batch);
  threads_.submit();
}

/// Resets all environments under another seed.
void Pool::Scheduler::send_reset(std::uint64_t seed) {
  check_idle("a reset under another seed");
  open_round(states.envs());  // may throw: before anything is changed
  states.initialize(seed);
  options.seed = seed;
  cursor = 0;
  for (int env = 0; env < states.envs(); ++env) states.flags().want_reset(env);
  enqueue_all();
}

void Pool::Scheduler::send_steps(std::span<const float> actions,
                                 std::span<const std::int32_t> env_ids) {
  check_alive();
  if (env_ids.empty() && in_flight_count == 0 && states.flags().can_step_all(states.renews())) {
    send_all_steps(actions);
    return;
  }
  check_steps(actions, env_ids);
  const auto width = static_cast<std::size_t>(states.compiled().action_size());
  const std::size_t count = env_ids.empty() ? in_flight_.size() : env_ids.size();
  open_round(static_cast<int>(count));
  for (std::size_t k = 0; k < count; ++k) {
    const int env = env_ids.empty() ? static_cast<int>(k) : env_ids[k];
    std::copy_n(actions.data() + k * width, width, states.action(env));
    states.flags().want_step(env);
    states.requests().hand_over(env);
    enqueue(env);
  }
  start_waiting(options.batch);
  threads_.submit();
}

/// Sends steps to all environments at once. None may be in flight or waiting for a reset.
void Pool::Scheduler::send_all_steps(std::span<const float> actions) {
  check_size(actions, in_flight_.size());
  open_round(states.envs());
  std::copy(actions.begin(), actions.end(), states.action(0));
  states.flags().want_step_all();
  states.requests().hand_over_all();
  enqueue_all();
}

void Pool::Scheduler::check_size(std::span<const float> actions, std::size_t count) const {
  check_values("actions", actions.size(), count, states.compiled().action_size());
}

void Pool::Scheduler::check_steps(std::span<const float> actions,
                                  std::span<const std::int32_t> env_ids) {
  const std::size_t count = env_ids.empty() ? in_flight_.size() : env_ids.size();
  check_size(actions, count);
  std::size_t k = 0;
  try {
    for (; k < count; ++k) {
      const std::int32_t env = env_ids.empty() ? static_cast<std::int32_t>(k) : env_ids[k];
      check_step(env);
      marked_[static_cast<std::size_t>(env)] = 1;
    }
  } catch (...) {
    unmark(env_ids, k);
    throw;
  }
  unmark(env_ids, count);
}

/// Checks that an environment can be stepped now. `marked_` contains the ids of the same send().
void Pool::Scheduler::check_step(std::int32_t env) {
  check_id(env);
  if (marked_[static_cast<std::size_t>(env)] != 0) refuse_twice("environment", env);
  const auto name = [env] { return "environment " + std::to_string(env); };  // on failure
  if (in_flight(env)) throw Error(name() + " is still in flight: recv() it before the next send()");
  if (!states.flags().started(env))
    throw Error(name() + " has not begun an episode: reset it first");
  if (options.autoreset == Autoreset::kDisabled && states.flags().ended(env)) {
    throw Error("the episode of " + name() +
                " has ended, and autoreset is disabled: reset it first");
  }
}

void Pool::Scheduler::unmark(std::span<const std::int32_t> env_ids, std::size_t count) {
  if (env_ids.empty()) {
    std::fill(marked_.begin(), marked_.end(), std::uint8_t{0});
    return;
  }
  for (std::size_t k = 0; k < count; ++k) marked_[static_cast<std::size_t>(env_ids[k])] = 0;
}

/// Selects the destination of the rows of the environments that are sent next.
void Pool::Scheduler::open_round(int count) {
  if (in_flight_count > 0) return;  // some are being written to `target_` now
  round_ = count == states.envs() && options.batch == states.envs();
  target_ = &staging_;
  if (!round_) return;
  target_ = &buffers_.next();
  std::iota(target_->env_id.begin(), target_->env_id.end(), 0);
  round_left_.store(count, std::memory_order_relaxed);
}

void Pool::Scheduler::enqueue(int env) {
  in_flight_[static_cast<std::size_t>(env)] = 1;
  ++in_flight_count;
  const int group = states.places().group_of(env);
  if (waits_) {
    waiting_.hold(group, states.places().bit(env));
  } else {
    start(group, states.places().bit(env));
  }
}

/// Adds lanes of a group to the next submit().
void Pool::Scheduler::start(int group, std::uint32_t lanes) {
  const std::uint64_t before = group_state_[static_cast<std::size_t>(group)].fetch_or(
      lanes | kOwned, std::memory_order_acq_rel);
  if ((before & kOwned) == 0) threads_.add(group);
}

/// Starts waiting environments that need not wait, and as many others as the next batch needs.
void Pool::Scheduler::start_waiting(int batch) {
  if (waiting_.count() == 0) return;
  const auto starts = [this](int group, std::uint32_t lanes) { start(group, lanes); };
  waiting_.release([this](int group, std::uint32_t lanes) { return !others_return(group, lanes); },
                   starts);
  while (in_flight_count - waiting_.count() < std::min(batch, in_flight_count)) {
    waiting_.release_fullest(starts);
  }
}

/// Whether recv() will return the rest of a group, so that its waiting lanes can stay for it.
bool Pool::Scheduler::others_return(int group, std::uint32_t lanes) const {
  const EnvironmentGroups& places = states.places();
  std::uint32_t rest = places.all_lanes(group) & ~lanes;
  if (rest == 0) return false;
  for (; rest != 0; rest &= rest - 1) {
    if (!in_flight(places.env_of(group, std::countr_zero(rest)))) return false;
  }
  return true;
}

/// Enqueues all environments. None may be in flight.
void Pool::Scheduler::enqueue_all() {
  std::fill(in_flight_.begin(), in_flight_.end(), std::uint8_t{1});
  in_flight_count = states.envs();
  for (int group = 0; group < states.places().count(); ++group) {
    // No thread reads a group that is not owned: the queue publishes it.
    group_state_[static_cast<std::size_t>(group)].store(states.places().all_lanes(group) | kOwned,
                                                        std::memory_order_relaxed);
    if (!round_) threads_.add(group);
  }
  if (round_) return threads_.submit_round();
  threads_.submit();
}

/// In a round all lanes of a group are in flight, so none can be sent while it runs.
void Pool::Scheduler::run(const int* groups, int count, int thread) {
  if (!round_) {
    for (int k = 0; k < count; ++k) run_lanes(groups[k], thread);
    return;
  }
  int envs = 0;
  for (int k = 0; k < count; ++k) {
    const std::uint32_t lanes = states.places().all_lanes(groups[k]);
    states.transition(groups[k], lanes, *target_, thread);
    group_state_[static_cast<std::size_t>(groups[k])].store(0, std::memory_order_relaxed);
    envs += std::popcount(lanes);
  }
  round_left_.fetch_sub(envs, std::memory_order_seq_cst);
  threads_.announce();
}

/// Lanes that are sent while the group runs are run by the same thread right after.
void Pool::Scheduler::run_lanes(int group, int thread) {
  std::atomic<std::uint64_t>& state = group_state_[static_cast<std::size_t>(group)];
  for (std::uint64_t idle = kOwned;; idle = kOwned) {
    const auto lanes =
        static_cast<std::uint32_t>(state.fetch_and(~kLaneBits, std::memory_order_acq_rel));
    states.transition(group, lanes, *target_, thread);
    // Before the announcement: once all lanes have returned, no thread owns a group, so that
    // enqueue_all() may run.
    const bool is_over = state.compare_exchange_strong(idle, 0, std::memory_order_acq_rel);
    done_.push(group, lanes);
    threads_.announce();
    if (is_over) return;
  }
}

/// Takes finished groups out of the queue.
void Pool::Scheduler::drain() {
  int group = 0;
  std::uint32_t lanes = 0;
  while (done_.pop(group, lanes)) {
    for (; lanes != 0; lanes &= lanes - 1) {
      const int env = states.places().env_of(group, std::countr_zero(lanes));
      finished_[static_cast<std::size_t>(env)] = 1;
      if (options.order == Order::kArrival) arrived_.push_back(env);
    }
  }
}

std::shared_ptr<const Batch> Pool::Scheduler::recv(ThreadPool::Clock::time_point deadline) {
  check_alive();
  if (in_flight_count == 0) {
    throw Error("recv() with nothing in flight: send() actions or a reset first");
  }
  if (round_) return recv_round(deadline);
  Batch& out = buffers_.next();
  const int count = std::min(options.batch, in_flight_count);
  if (options.order == Order::kFixed) choose_in_turn(count);
  if (waiting_.count() > 0) {
    start_waiting(count);
    threads_.submit();
  }
  const auto ready = [&] {
    drain();
    return batch_ready(count);
  };
  if (!threads_.wait(ready, deadline)) return nullptr;
  if (options.order == Order::kArrival) choose_oldest(count);
  gather(out);
  return finish(out);
}

std::shared_ptr<const Batch> Pool::Scheduler::recv_round(ThreadPool::Clock::time_point deadline) {
  const auto ready = [&] { return round_left_.load(std::memory_order_seq_cst) == 0; };
  if (!threads_.wait(ready, deadline)) return nullptr;
  round_ = false;
  in_flight_count = 0;
  std::fill(in_flight_.begin(), in_flight_.end(), std::uint8_t{0});
  target_->rows = states.envs();
  return finish(*target_);
}

/// The next `count` environments in flight, from the cursor on.
void Pool::Scheduler::choose_in_turn(int count) {
  chosen_.clear();
  for (int env = cursor; static_cast<int>(chosen_.size()) < count;
       env = (env + 1) % states.envs()) {
    if (in_flight(env)) chosen_.push_back(env);
  }
}

void Pool::Scheduler::choose_oldest(int count) {
  chosen_.assign(arrived_.begin(), arrived_.begin() + count);
  arrived_.erase(arrived_.begin(), arrived_.begin() + count);
}

bool Pool::Scheduler::batch_ready(int count) {
  if (options.order == Order::kArrival) return static_cast<int>(arrived_.size()) >= count;
  return std::all_of(chosen_.begin(), chosen_.end(), [&](std::int32_t env) {
    return finished_[static_cast<std::size_t>(env)] != 0;
  });
}

/// Copies the chosen environments' rows, one run of consecutive rows at a time.
void Pool::Scheduler::gather(Batch& out) {
  const auto count = static_cast<int>(chosen_.size());
  for (int at = 0, run = 0; at < count; at += run) {
    const int first = chosen_[static_cast<std::size_t>(at)];
    run = 1;
    while (at + run < count && chosen_[static_cast<std::size_t>(at + run)] == first + run) ++run;
    out.take(staging_, first, run, at);
  }
  for (const std::int32_t env : chosen_) {
    in_flight_[static_cast<std::size_t>(env)] = finished_[static_cast<std::size_t>(env)] = 0;
  }
  if (options.order == Order::kFixed) cursor = (chosen_.back() + 1) % states.envs();
  in_flight_count -= count;
  out.rows = count;
}

std::shared_ptr<const Batch> Pool::Scheduler::finish(Batch& out) {
  for (int k = 0; k < out.rows; ++k) faults += out.fault[static_cast<std::size_t>(k)];
  auto batch = buffers_.commit();
  try {
    if (observer) observer->received(*batch, states);
  } catch (const std::exception& error) {
    observer_failure_ = error.what();  // thrown by the next call: these rows are complete
  }
  return batch;
}

}  // namespace skybody
