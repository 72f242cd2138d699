#include "python/native/python_pool.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/system/process_id.h"
#include "core/io/files/flight_log.h"

namespace skybody::python {
namespace {

/// Number of values beyond [-1, 1]. Values that are not finite cause a fault and are not counted.
std::size_t clipped_values(std::span<const float> actions) {
  std::size_t count = 0;
  for (const float a : actions) {
    const float size = std::fabs(a);
    count += size > 1.0f && size <= std::numeric_limits<float>::max() ? 1 : 0;
  }
  return count;
}

}  // namespace

PythonPool::PythonPool(const LoadedScenario& compiled, const PoolOptions& options)
    : compiled_(compiled), process_(process_id()) {
  const nb::gil_scoped_release release;
  pool_ = rethrow_as_argument_error(
      [&] { return std::make_unique<Pool>(compiled_.shared(), options); });
  envs_ = pool_->envs();
  batch_ = pool_->batch();
  threads_ = pool_->threads();
  pinned_threads_ = pool_->pinned_threads();
}

PythonPool::~PythonPool() { let_go(); }

bool PythonPool::of_this_process() const { return process_id() == process_; }

/// In a forked child the Pool is not destroyed: its threads stayed in the parent, and waiting for
/// them would never end. Its recording is finished by the parent.
void PythonPool::let_go() {
  if (!of_this_process()) {
    static_cast<void>(pool_.release());
  } else {
    pool_.reset();
  }
}

Pool& PythonPool::open() const {
  if (!pool_) throw Error("this pool is closed: make a new one");
  if (!of_this_process()) {
    throw Error("this pool was made in process " + std::to_string(process_) +
                ", of which this one is a fork: make a pool of its own in each process");
  }
  return *pool_;
}

void PythonPool::send(std::span<const float> actions, std::span<const std::int32_t> env_ids) {
  call_with_argument([&](Pool& pool) {
    pool.send(actions, env_ids);
    count_clipped(actions, env_ids);
  });
}

/// One pass over all values shows that there are none, which is the usual case.
void PythonPool::count_clipped(std::span<const float> actions,
                               std::span<const std::int32_t> env_ids) {
  const std::size_t all = clipped_values(actions);
  all_clipped_ += all;
  if (all == 0 && clipped_.empty()) return;
  clipped_.resize(static_cast<std::size_t>(envs_));
  const auto width = static_cast<std::size_t>(compiled_->action_size());
  for (std::size_t row = 0; row * width < actions.size(); ++row) {
    const std::size_t env = env_ids.empty() ? row : static_cast<std::size_t>(env_ids[row]);
    clipped_[env] = static_cast<std::int32_t>(clipped_values(actions.subspan(row * width, width)));
  }
}

std::vector<std::int32_t> PythonPool::clipped(const Batch& batch) const {
  std::vector<std::int32_t> counts;
  if (clipped_.empty()) return counts;
  for (std::size_t row = 0; row < static_cast<std::size_t>(batch.rows); ++row) {
    const auto env = static_cast<std::size_t>(batch.env_id[row]);
    counts.push_back(batch.was_reset[row] != 0 ? 0 : clipped_[env]);
  }
  const bool is_any = std::any_of(counts.begin(), counts.end(), [](int n) { return n > 0; });
  return is_any ? counts : std::vector<std::int32_t>{};
}

std::shared_ptr<const Batch> PythonPool::recv() {
  return call([](Pool& pool) {
    if (!pool.broken() && pool.in_flight() == 0) {
      throw nb::value_error("recv() without a send(): nothing is in flight");
    }
    return receive(pool);
  });
}

std::shared_ptr<const Batch> PythonPool::step(std::span<const float> actions) {
  return call([&](Pool& pool) {
    check_not_interrupted(pool);
    with_argument(pool, [&](Pool& ready) { ready.send(actions); });
    count_clipped(actions, {});
    return receive(pool);
  });
}

void PythonPool::check_not_interrupted(const Pool& pool) {
  if (pool.in_flight() == 0 || pool.broken()) return;
  throw Error("the last step was interrupted and " + std::to_string(pool.in_flight()) +
              " environments are still in flight: reset(), which waits for them and begins anew");
}

/// Waits without the GIL, and checks for signals with it.
std::shared_ptr<const Batch> PythonPool::receive(Pool& pool) {
  constexpr std::chrono::milliseconds kPatience(50);
  for (;;) {
    if (auto batch = pool.recv(kPatience)) return batch;
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

/// HDF5's clean-up at exit would crash after a write that failed on a full disk, and in a forked
/// child it would finish the parent's file. (h5py's packages contain their own HDF5.)
void PythonPool::record(const std::filesystem::path& file, bool states) {
  skip_hdf5_cleanup_at_exit();
  call([&](Pool& pool) {
    if (recorder_ && recorder_->recording()) {
      throw Error("this pool is being recorded to " + recorder_->file().string() +
                  ": stop_recording() first");
    }
    recorder_ = start_recording(pool, file, {compiled_.options(), states});
  });
}

void PythonPool::stop_recording() {
  call([&](Pool&) {
    if (!recorder_) throw Error("stop_recording() of a pool that is not being recorded");
    finish_recording();
  });
}

void PythonPool::finish_recording() {
  const auto recorder = std::exchange(recorder_, nullptr);
  if (recorder) skybody::stop_recording(*pool_, *recorder);
}

void PythonPool::close() {
  const Exclusive alone(in_use_, "pool");
  const nb::gil_scoped_release release;
  try {
    if (of_this_process()) finish_recording();
  } catch (...) {
    let_go();
    throw;
  }
  let_go();
}

}  // namespace skybody::python
