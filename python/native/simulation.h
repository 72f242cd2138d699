// A Simulation for Python: one thread at a time, without the GIL.
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <utility>

#include "core/simulation/simulation.h"
#include "python/native/exclusive.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

class DirectSimulation {
 public:
  DirectSimulation(const LoadedScenario& compiled, Simulation simulation)
      : compiled_(compiled), simulation_(std::move(simulation)) {}

  const LoadedScenario& compiled() const { return compiled_; }

  /// Calls work(Simulation&) exclusively and without the GIL.
  /// @throws Error if in use by another thread
  template <class Work>
  decltype(auto) call(Work&& work) {
    const Exclusive alone(in_use_, "simulation");
    const nb::gil_scoped_release release;
    return std::forward<Work>(work)(simulation_);
  }
  /// The same with the GIL held, for very short work.
  template <class Work>
  decltype(auto) look(Work&& work) {
    const Exclusive alone(in_use_, "simulation");
    return std::forward<Work>(work)(simulation_);
  }

 private:
  LoadedScenario compiled_;
  Simulation simulation_;
  std::atomic<bool> in_use_ = false;
};

/// Adds the methods of direct control and their result types.
void bind_direct_control(nb::module_& m, nb::class_<DirectSimulation>& c);

}  // namespace skybody::python
