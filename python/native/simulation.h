// A Simulation for Python: one thread at a time, without the GIL.
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <type_traits>
#include <utility>

#include "core/simulation/simulation.h"
#include "python/native/errors.h"
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

/// A function of Python that calls one of the simulation. Errors of its arguments are ValueErrors.
template <class Result, class... Arguments>
auto of(Result (Simulation::*member)(Arguments...) const) {
  return [member](DirectSimulation& s, const std::remove_cvref_t<Arguments>&... arguments) {
    return s.look([&](Simulation& sim) {
      if constexpr (sizeof...(Arguments) == 0) {
        return (sim.*member)();
      } else {
        return rethrow_as_argument_error([&] { return (sim.*member)(arguments...); });
      }
    });
  };
}

/// Adds the methods of direct control and their result types.
void bind_direct_control(nb::module_& m, nb::class_<DirectSimulation>& c);

}  // namespace skybody::python
