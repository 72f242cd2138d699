// A SimulationPool for Python: one thread at a time, without the GIL, closable.
#pragma once

#include <nanobind/nanobind.h>
#include <sys/types.h>

#include <atomic>
#include <memory>
#include <utility>

#include "core/simulation/simulation_pool.h"
#include "python/native/errors.h"
#include "python/native/exclusive.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

class PythonSimulationPool {
 public:
  /// @throws ValueError if an option is out of range
  PythonSimulationPool(const LoadedScenario& compiled, const SimulationPoolOptions& options);
  ~PythonSimulationPool();
  PythonSimulationPool(const PythonSimulationPool&) = delete;
  PythonSimulationPool& operator=(const PythonSimulationPool&) = delete;

  /// Calls work(SimulationPool&) exclusively and without the GIL.
  /// @throws Error if closed, in use by another thread, or made before a fork()
  template <class Work>
  decltype(auto) call(Work&& work) {
    const Exclusive alone(in_use_, "pool of simulations");
    SimulationPool& pool = open();
    const nb::gil_scoped_release release;
    return std::forward<Work>(work)(pool);
  }

  void close();
  bool closed() const { return !pool_; }
  const LoadedScenario& compiled() const { return compiled_; }
  int size() const { return size_; }
  int threads() const { return threads_; }
  int pinned_threads() const { return pinned_threads_; }

 private:
  SimulationPool& open() const;

  LoadedScenario compiled_;
  int process_;
  std::unique_ptr<SimulationPool> pool_;
  int size_ = 0, threads_ = 0, pinned_threads_ = 0;
  std::atomic<bool> in_use_ = false;
};

}  // namespace skybody::python
