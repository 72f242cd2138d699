#include "python/native/python_pool.h"

#include <chrono>
#include <string>
#include <utility>

#include "core/base/process_id.h"
#include "core/io/flight_log.h"

namespace skybody::python {

PythonPool::PythonPool(const LoadedScenario& compiled, const PoolOptions& options)
    : compiled_(compiled), process_(process_id()) {
  const nb::gil_scoped_release release;
  pool_ = blame_argument([&] { return std::make_unique<Pool>(compiled_.shared(), options); });
  envs_ = pool_->envs();
  batch_ = pool_->batch();
  threads_ = pool_->threads();
  pinned_threads_ = pool_->pinned_threads();
}

PythonPool::~PythonPool() { let_go(); }

bool PythonPool::of_this_process() const { return process_id() == process_; }

/// In a forked child the Pool is left as it is: its threads stayed in the parent, and waiting for
/// them would never end. A recording that it keeps stays the parent's to finish.
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
    return receive(pool);
  });
}

void PythonPool::check_not_interrupted(const Pool& pool) {
  if (pool.in_flight() == 0 || pool.broken()) return;
  throw Error("the last step was interrupted and " + std::to_string(pool.in_flight()) +
              " environments are still in flight: reset(), which waits for them and begins anew");
}

/// Waits without the GIL, and looks for signals with it.
std::shared_ptr<const Batch> PythonPool::receive(Pool& pool) {
  constexpr std::chrono::milliseconds kPatience(50);
  for (;;) {
    if (auto batch = pool.recv(kPatience)) return batch;
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

/// HDF5's clean-up at exit would crash where a file could not be written for want of space, and in
/// a forked child it would finish the parent's file. (h5py's packages bring an HDF5 of their own.)
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
