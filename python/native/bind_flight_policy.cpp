// Policies that fly a Simulation from Python, as `skybody run --policy` flies them.
#include <nanobind/stl/string.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/system/error.h"
#include "core/policy/policy.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/loaded_scenario.h"
#include "python/native/simulation.h"

namespace skybody::python {
namespace {

/// A policy with the scenario that it was made for.
class FlightPolicy {
 public:
  FlightPolicy(const LoadedScenario& compiled, const std::string& name, std::uint64_t seed)
      : compiled_(compiled), policy_(make_policy(name, *compiled, seed)) {
    warning_ = policy_->check_fits(*compiled);
  }

  const std::string& warning() const { return warning_; }

  std::vector<float> act(const Simulation& simulation) {
    if (&simulation.compiled() != &*compiled_) {
      throw nb::value_error("the simulation is of another loaded scenario than the policy");
    }
    std::vector<float> action(static_cast<std::size_t>(compiled_->action_size()));
    policy_->act(simulation, action);
    return action;
  }

 private:
  LoadedScenario compiled_;
  std::unique_ptr<Policy> policy_;
  std::string warning_;
};

nb::object act(FlightPolicy& policy, DirectSimulation& simulation) {
  const std::vector<float> action =
      simulation.look([&](Simulation& sim) { return policy.act(sim); });
  return array_of<float>(action);
}

}  // namespace

void bind_flight_policy(nb::module_& m) {
  nb::class_<FlightPolicy>(m, "FlightPolicy",
                           "A policy of `skybody run --policy` for one Simulation at a time: its "
                           "recurrent state is that of the simulation's episode.")
      .def(nb::init<const LoadedScenario&, const std::string&, std::uint64_t>(),
           nb::arg("compiled"), nb::arg("policy") = "hold", nb::arg("seed") = 0,
           "compiled: the scenario of the simulations\n"
           "policy: `zero`, `random`, `hold`, `shipped`, or the path of a policy.h5 or of a "
           "training run\n"
           "seed: of `random`\n\n"
           "Raises Error if it cannot be read or does not fit the scenario.")
      .def_prop_ro("warning", &FlightPolicy::warning,
                   "Text if the policy was trained in another scenario; otherwise empty.")
      .def("act", &act, nb::arg("simulation"),
           nb::sig("def act(self, simulation: Simulation) -> "
                   "numpy.typing.NDArray[numpy.float32]"),
           "The action (A,) in [-1, 1] for the simulation's last observation.\n\n"
           "Raises ValueError if the simulation is of another loaded scenario.");
}

}  // namespace skybody::python
