#include "python/native/simulation_pool.h"

#include "core/base/system/process_id.h"

namespace skybody::python {

PythonSimulationPool::PythonSimulationPool(const LoadedScenario& compiled,
                                           const SimulationPoolOptions& options)
    : compiled_(compiled), process_(process_id()) {
  const nb::gil_scoped_release release;
  pool_ = rethrow_as_argument_error(
      [&] { return std::make_unique<SimulationPool>(compiled_.shared(), options); });
  size_ = pool_->size();
  threads_ = pool_->threads();
  pinned_threads_ = pool_->pinned_threads();
}

/// A forked child has none of the threads and must not wait for them.
PythonSimulationPool::~PythonSimulationPool() {
  if (process_id() != process_) static_cast<void>(pool_.release());
}

SimulationPool& PythonSimulationPool::open() const {
  if (!pool_) throw Error("this pool of simulations is closed: make a new one");
  if (process_id() != process_) {
    throw Error("this pool of simulations was made in process " + std::to_string(process_) +
                ", of which this one is a fork: make a pool of its own in each process");
  }
  return *pool_;
}

void PythonSimulationPool::close() {
  const Exclusive alone(in_use_, "pool of simulations");
  if (process_id() != process_) {
    static_cast<void>(pool_.release());
    return;
  }
  const nb::gil_scoped_release release;
  pool_.reset();
}

}  // namespace skybody::python
