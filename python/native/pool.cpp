#include "python/native/pool.h"

#include <unistd.h>

#include <chrono>

namespace skybody::python {

Pool::Pool(const LoadedEnvironment& environment, const VecEnvOptions& options)
    : environment_(environment), process_(getpid()) {
  const nb::gil_scoped_release release;
  engine_ =
      blame_argument([&] { return std::make_unique<VecEnv>(environment_.shared(), options); });
  envs_ = engine_->envs();
  batch_ = engine_->batch();
  threads_ = engine_->threads();
  pinned_threads_ = engine_->pinned_threads();
}

Pool::~Pool() { let_go(); }

/// In a forked child the engine is left as it is: its threads stayed in the parent, and waiting for
/// them would never end.
void Pool::let_go() {
  if (getpid() != process_) {
    static_cast<void>(engine_.release());
  } else {
    engine_.reset();
  }
}

VecEnv& Pool::open() const {
  if (!engine_) throw Error("this pool is closed: make a new one");
  if (getpid() != process_) {
    throw Error("this pool was made in process " + std::to_string(process_) +
                ", of which this one is a fork: make a pool of its own in each process");
  }
  return *engine_;
}

std::shared_ptr<const Batch> Pool::recv() {
  constexpr std::chrono::milliseconds kPatience(50);
  const Exclusive alone(in_use_, "pool");
  VecEnv& engine = open();
  for (;;) {
    std::shared_ptr<const Batch> batch;
    {
      const nb::gil_scoped_release release;
      if (!broken_ && engine.in_flight() == 0) {
        throw nb::value_error("recv() without a send(): nothing is in flight");
      }
      try {
        batch = engine.recv(kPatience);
      } catch (const BufferInUse&) {
        throw;
      } catch (...) {
        broken_ = true;
        throw;
      }
    }
    if (batch) return batch;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

void Pool::close() {
  const Exclusive alone(in_use_, "pool");
  const nb::gil_scoped_release release;
  let_go();
}

}  // namespace skybody::python
