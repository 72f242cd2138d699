#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <vector>

#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/differentiable_envs.h"
#include "python/native/exclusive.h"
#include "python/native/properties.h"

namespace skybody::python {
namespace {

using Class = nb::class_<DifferentiableEnvs>;

/// Calls work() exclusively and without the GIL.
template <class Work>
void call(DifferentiableEnvs& envs, Work&& work) {
  const Exclusive alone(envs.in_use(), "differentiable environment");
  const nb::gil_scoped_release release;
  work();
}

void construct(DifferentiableEnvs* self, const LoadedScenario& compiled, int num_envs, int steps,
               std::uint64_t seed) {
  const nb::gil_scoped_release release;
  new (self) DifferentiableEnvs(compiled, num_envs, steps, seed);
}

nb::object observations(const DifferentiableEnvs& envs) {
  return copy_of<float>(envs.observations(), {static_cast<std::size_t>(envs.size()),
                                              static_cast<std::size_t>(envs.observation_size())});
}

nb::object status(const DifferentiableEnvs& envs) { return array_of<std::uint64_t>(envs.status()); }

nb::object reset(DifferentiableEnvs& envs, std::optional<std::uint64_t> seed) {
  call(envs, [&] { envs.reset(seed); });
  return observations(envs);
}

nb::tuple step(DifferentiableEnvs& envs, nb::handle actions) {
  const auto rows = read_array<float>(actions, "actions", {envs.size(), envs.action_size()});
  call(envs, [&] { envs.step(rows.span()); });
  return nb::make_tuple(observations(envs), array_of<float>(envs.rewards()), status(envs));
}

nb::tuple pull_back(DifferentiableEnvs& envs, std::int64_t transition, nb::handle d_observation,
                    nb::handle d_reward, nb::handle d_state) {
  const auto observation =
      read_array<float>(d_observation, "d_observation", {envs.size(), envs.observation_size()});
  const auto reward = read_array<float>(d_reward, "d_reward", {envs.size()});
  const auto later = read_array<double>(d_state, "d_state", {envs.size(), envs.state_size()});
  const auto size = static_cast<std::size_t>(envs.size());
  const auto states = static_cast<std::size_t>(envs.state_size());
  const auto actions = static_cast<std::size_t>(envs.action_size());
  std::vector<double> state(size * states);
  std::vector<float> action(size * actions);
  call(envs, [&] {
    envs.pull_back(transition, {observation.span(), reward.span(), later.span()}, state, action);
  });
  return nb::make_tuple(copy_of<float>(action, {size, actions}),
                        copy_of<double>(state, {size, states}));
}

nb::object refuse_pickling(const DifferentiableEnvs&) {
  throw nb::type_error(
      "a DifferentiableEnv cannot be pickled or copied: make one anew, from the scenario and the "
      "seed");
}

void bind_flow(Class& c) {
  c.def("reset", &reset, nb::arg("seed") = nb::none(),
        nb::sig("def reset(self, seed: int | None = None) -> "
                "numpy.typing.NDArray[numpy.float32]"),
        "Begins the next episode of all environments, or with a seed episode 1 under it, and "
        "forgets the record.\n\n"
        "Returns the observations (N, O).");
  c.def("step", &step, nb::arg("actions").none(),
        nb::sig("def step(self, actions: numpy.typing.NDArray[numpy.float32]) -> "
                "tuple[numpy.typing.NDArray[numpy.float32], "
                "numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.uint64]]"),
        "One recorded transition of all environments.\n\n"
        "actions: (N, A) float32 in [-1, 1] (clipped)\n\n"
        "Returns observations (N, O), rewards (N,) and status (N,): bits 1 terminated, 2 "
        "truncated, 4 fault.\n"
        "Raises TypeError on another dtype, ValueError on another shape, Error before reset() or "
        "if the record is full.");
  c.def("pull_back", &pull_back, nb::arg("transition"), nb::arg("d_observation").none(),
        nb::arg("d_reward").none(), nb::arg("d_state").none(),
        nb::sig("def pull_back(self, transition: int, d_observation: "
                "numpy.typing.NDArray[numpy.float32], d_reward: "
                "numpy.typing.NDArray[numpy.float32], d_state: "
                "numpy.typing.NDArray[numpy.float64]) -> "
                "tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float64]]"),
        "Derivatives of a sum by the action of a transition and by the state before it.\n\n"
        "transition: its number\n"
        "d_observation (N, O), d_reward (N,): derivatives by its results\n"
        "d_state (N, state_size): by the state after it, from the later transitions\n\n"
        "Returns derivatives by the action (N, A) and by the state before it (N, state_size).\n"
        "Raises TypeError on another dtype, ValueError on another shape, Error if the transition "
        "is not in the record.");
}

}  // namespace

void bind_differentiable_envs(nb::module_& m) {
  Class c(m, "DifferentiableEnv",
          "Environments whose transitions have derivatives (core/derivative). Use it through "
          "skybody.DifferentiableEnv.");
  c.def("__init__", &construct, nb::arg("compiled"), nb::arg("num_envs"), nb::arg("steps"),
        nb::arg("seed") = 0,
        "steps: greatest number of transitions between two resets\n\n"
        "Raises InputError if a plugin has no derivatives, Error if the integrator has none.");
  bind_flow(c);
  c.def_prop_ro("compiled", &DifferentiableEnvs::scenario, nb::rv_policy::reference_internal,
                "The scenario that it steps.");
  c.def_prop_ro("num_envs", &DifferentiableEnvs::size, "N: number of environments.");
  c.def_prop_ro("steps", &DifferentiableEnvs::steps,
                "Greatest number of transitions between two resets.");
  c.def_prop_ro("state_size", &DifferentiableEnvs::state_size,
                "Number of values per environment of `d_state`.");
  c.def_prop_ro("transition", &DifferentiableEnvs::transition,
                "Number of the next transition, counted over all resets from 0.");
  def_unpicklable(c, &refuse_pickling);
}

}  // namespace skybody::python
