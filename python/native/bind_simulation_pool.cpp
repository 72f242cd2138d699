#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/direct_control.h"
#include "python/native/properties.h"
#include "python/native/simulation_pool.h"
#include "python/native/state_array.h"

namespace skybody::python {
namespace {

using Class = nb::class_<PythonSimulationPool>;

/// The environments of a call: given indices, or all of them for None. Requires the GIL.
std::vector<int> read_envs(const PythonSimulationPool& pool, nb::handle envs) {
  std::vector<int> out;
  if (envs.is_none()) {
    for (int i = 0; i < pool.size(); ++i) out.push_back(i);
  } else {
    const auto ids = read_array<std::int32_t>(envs, "envs", {-1});
    out.assign(ids.span().begin(), ids.span().end());
  }
  return out;
}

/// Errors in the indices are reported as errors of the argument; later errors are the engine's.
void check_envs(const PythonSimulationPool& pool, const std::vector<int>& envs) {
  rethrow_as_argument_error([&] { check_indices("environment", envs, pool.size()); });
}

std::vector<int> chosen(const PythonSimulationPool& pool, nb::handle envs) {
  std::vector<int> out = read_envs(pool, envs);
  check_envs(pool, out);
  return out;
}

void construct(PythonSimulationPool* self, const LoadedScenario& compiled, int num_envs,
               std::uint64_t seed, std::uint64_t first_env_id, bool pin_threads, int num_threads) {
  new (self)
      PythonSimulationPool(compiled, {num_envs, seed, first_env_id, pin_threads, num_threads});
}

void reset(PythonSimulationPool& pool, nb::handle envs, std::optional<std::uint64_t> seed) {
  const auto ids = chosen(pool, envs);
  pool.call([&](SimulationPool& p) { seed ? p.reset(ids, *seed) : p.reset(ids); });
}

void step(PythonSimulationPool& pool, nb::handle actions, nb::handle envs) {
  const auto ids = chosen(pool, envs);
  const auto rows = read_array<float>(
      actions, "actions", {static_cast<std::int64_t>(ids.size()), pool.compiled()->action_size()});
  pool.call([&](SimulationPool& p) { p.step(ids, rows.span()); });
}

void command(PythonSimulationPool& pool, nb::handle values, const std::string& robot,
             nb::handle envs) {
  const auto ids = chosen(pool, envs);
  const int width = pool.call([&](SimulationPool& p) {
    return rethrow_as_argument_error([&] { return p.simulation(0).command_size(robot); });
  });
  const auto rows =
      read_array<double>(values, "values", {static_cast<std::int64_t>(ids.size()), width});
  pool.call([&](SimulationPool& p) {
    rethrow_as_argument_error([&] { p.command(ids, robot, rows.span()); });
  });
}

void advance(PythonSimulationPool& pool, std::int64_t steps, nb::handle envs) {
  const auto ids = chosen(pool, envs);
  advance_in_pieces(steps, [&](std::int64_t piece) {
    pool.call([&](SimulationPool& p) { p.advance(ids, piece); });
    return true;
  });
}

/// Values of all environments one after another, `width` from each.
template <class T, class Write>
std::vector<T> gather(PythonSimulationPool& pool, std::size_t width, Write&& write) {
  std::vector<T> values(static_cast<std::size_t>(pool.size()) * width);
  pool.call([&](SimulationPool& p) {
    for (const int i : p.all()) {
      write(p.simulation(i), values.data() + static_cast<std::size_t>(i) * width);
    }
  });
  return values;
}

nb::object state(PythonSimulationPool& pool, const std::string& path) {
  return state_array(pool.compiled(), path, {static_cast<std::size_t>(pool.size())},
                     [&](std::vector<double>& values) {
                       pool.call([&](SimulationPool& p) { p.state(path, values); });
                     });
}

nb::object observations(PythonSimulationPool& pool) {
  const auto width = static_cast<std::size_t>(pool.compiled()->observation_size());
  const auto values = gather<float>(pool, width, [](Simulation& sim, float* out) {
    std::copy(sim.observation().begin(), sim.observation().end(), out);
  });
  return copy_of<float>(values, {static_cast<std::size_t>(pool.size()), width});
}

/// One value of each environment. @tparam T  of the array
template <class T, T (Simulation::*value)() const>
nb::object each_value(PythonSimulationPool& pool) {
  const auto values = gather<T>(pool, 1, [](Simulation& sim, T* out) { *out = (sim.*value)(); });
  return copy_of<T>(values, {static_cast<std::size_t>(pool.size())});
}

std::optional<std::vector<std::optional<std::string>>> fault_reasons(PythonSimulationPool& pool) {
  const auto statuses = gather<std::uint64_t>(
      pool, 1, [](Simulation& sim, std::uint64_t* out) { *out = sim.status(); });
  const auto is_fault = [](std::uint64_t status) { return (status & kFault) != 0; };
  if (std::none_of(statuses.begin(), statuses.end(), is_fault)) return std::nullopt;
  std::vector<std::optional<std::string>> reasons(statuses.size());
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (is_fault(statuses[i])) reasons[i] = pool.compiled()->fault_reason(statuses[i]);
  }
  return reasons;
}

nb::object refuse_pickling(const PythonSimulationPool&) {
  throw nb::type_error(
      "a SimulationPool cannot be pickled or copied: it has threads. Make one anew in the other "
      "process, from the scenario and the seed");
}

constexpr const char* kEnvsText = "envs: (n,) int32, each at most once; None: all in order\n\n";

void bind_flow(Class& c) {
  c.def(
      "reset", &reset, nb::arg("envs") = nb::none(), nb::arg("seed") = nb::none(),
      nb::sig("def reset(self, envs: numpy.typing.NDArray[numpy.int32] | None = None, seed: "
              "int | None = None) -> None"),
      (std::string(
           "Begins the next episode of some environments, or with a seed episode 1 under it.\n\n") +
       kEnvsText + "Raises ValueError if a number is out of range or twice there.")
          .c_str());
  c.def("step", &step, nb::arg("actions").none(), nb::arg("envs") = nb::none(),
        nb::sig("def step(self, actions: numpy.typing.NDArray[numpy.float32], envs: "
                "numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        (std::string(
             "One step of each: action_repeat physics steps. An ended episode goes on until it is\n"
             "reset.\n\n"
             "actions: (n, A) float32 in [-1, 1] (clipped)\n") +
         kEnvsText +
         "Raises TypeError on another dtype, ValueError on another shape, Error before reset().")
            .c_str());
  c.def(
      "command", &command, nb::arg("values").none(), nb::arg("robot") = "",
      nb::arg("envs") = nb::none(),
      nb::sig("def command(self, values: numpy.typing.NDArray[numpy.float64], robot: str = "
              "\"\", envs: numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
      (std::string("Sets the command of a robot's chains of controllers, as Simulation.command.\n\n"
                   "values: (n, command_size) float64, in the signal's units\n") +
       kEnvsText + "Raises ValueError likewise, and before reset().")
          .c_str());
  c.def("advance", &advance, nb::arg("physics_steps") = 1, nb::arg("envs") = nb::none(),
        nb::sig("def advance(self, physics_steps: int = 1, envs: "
                "numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        (std::string("Physics steps of each under its commands. An environment whose physics gives "
                     "up ends its\n"
                     "episode as a fault (`status`). KeyboardInterrupt gets through.\n\n") +
         kEnvsText + "Raises ValueError if physics_steps < 0, Error before reset().")
            .c_str());
  c.def(
      "evaluate",
      [](PythonSimulationPool& pool, nb::handle envs) {
        const auto ids = chosen(pool, envs);
        pool.call([&](SimulationPool& p) { p.evaluate(ids); });
      },
      nb::arg("envs") = nb::none(),
      nb::sig("def evaluate(self, envs: numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
      "Ends a transition made by command and advance, as Simulation.evaluate.");
  c.def("close", &PythonSimulationPool::close,
        "Ends the threads. May be called again; any other call raises Error from then on.");
  def_context(c, "SimulationPool");
}

/// Adds a property with a value of the state of all environments.
void def_state(Class& c, const char* name, const char* path, const char* doc) {
  def_array(
      c, name, "float64", [path](PythonSimulationPool& p) { return state(p, path); }, doc);
}

void bind_states(Class& c) {
  c.def(
      "state", &state, nb::arg("path"),
      nb::sig("def state(self, path: str) -> numpy.typing.NDArray[numpy.float64]"),
      "A value of the state of all environments, (num_envs, *shape) float64, fresh. What there is, "
      "with\n"
      "units, frames and shapes: CompiledScenario.state_values.\n\n"
      "Raises ValueError naming the nearest paths if there is none.");
  def_state(c, "positions", "bodies.position",
            "(num_envs, bodies, 3) float64, fresh: origins, world axes [m].");
  def_state(c, "rotations", "bodies.rotation",
            "(num_envs, bodies, 4) float64, fresh: unit quaternions w x y z, world from body.");
  def_state(c, "velocities", "bodies.velocity",
            "(num_envs, bodies, 3) float64, fresh: of the origins, world axes [m/s].");
  def_state(c, "angular_velocities", "bodies.angular_velocity",
            "(num_envs, bodies, 3) float64, fresh: body axes [rad/s].");
  def_state(c, "rotor_speeds", "rotor_speed", "(num_envs, rotors) float64, fresh [rad/s].");
  def_state(c, "times", "time", "(num_envs,) float64: since each environment's reset [s].");
  def_array(c, "observations", "float32", &observations,
            "(num_envs, O) float32, fresh: of the scenario's task, after the last reset,\n"
            "step or evaluate.");
  def_array(c, "rewards", "float32", each_value<float, &Simulation::reward>,
            "(num_envs,) float32: of the scenario's task, likewise.");
  def_array(c, "status", "uint64", each_value<std::uint64_t, &Simulation::status>,
            "(num_envs,) uint64: bits of the last transition: 1 terminated, 2 truncated, 4 fault.");
  c.def_prop_ro(
      "fault_reasons", &fault_reasons,
      "Per environment why it is a fault, None where it is none; None where none is one.");
}

/// Calls work(Simulation&) for one environment. @throws ValueError if there is no such environment
template <class Work>
decltype(auto) with_env(PythonSimulationPool& pool, int env, Work&& work) {
  check_envs(pool, {env});
  return pool.call([&](SimulationPool& p) {
    return rethrow_as_argument_error([&] { return work(p.simulation(env)); });
  });
}

void bind_one_env(Class& c) {
  c.def(
      "teleport",
      [](PythonSimulationPool& pool, int env, nb::handle position, nb::handle rotation,
         nb::handle velocity, nb::handle angular_velocity, const std::string& robot) {
        const NewMotion motion(position, rotation, velocity, angular_velocity);
        with_env(pool, env,
                 [&](Simulation& sim) { sim.teleport(robot, motion.applied_to(sim.base(robot))); });
      },
      nb::arg("env"), nb::arg("position") = nb::none(), nb::arg("rotation") = nb::none(),
      nb::arg("velocity") = nb::none(), nb::arg("angular_velocity") = nb::none(),
      nb::arg("robot") = "",
      nb::sig("def teleport(self, env: int, position: numpy.typing.NDArray[numpy.float64] | None "
              "= None, rotation: numpy.typing.NDArray[numpy.float64] | None = None, velocity: "
              "numpy.typing.NDArray[numpy.float64] | None = None, angular_velocity: "
              "numpy.typing.NDArray[numpy.float64] | None = None, robot: str = \"\") -> None"),
      "Simulation.teleport in one environment.");
  c.def(
      "param",
      [](PythonSimulationPool& pool, int env, const std::string& path) {
        return with_env(pool, env, [&](Simulation& sim) { return sim.param(path); });
      },
      nb::arg("env"), nb::arg("path"), "Simulation.param of one environment.");
  c.def(
      "set_param",
      [](PythonSimulationPool& pool, int env, const std::string& path, double value) {
        with_env(pool, env, [&](Simulation& sim) { sim.set_param(path, value); });
      },
      nb::arg("env"), nb::arg("path"), nb::arg("value"),
      "Simulation.set_param in one environment.");
  c.def(
      "save",
      [](PythonSimulationPool& pool, int env) {
        return with_env(pool, env, [](Simulation& sim) { return sim.save(); });
      },
      nb::arg("env"), "Simulation.save of one environment.");
  c.def(
      "restore",
      [](PythonSimulationPool& pool, int env, const Snapshot& snapshot) {
        with_env(pool, env, [&](Simulation& sim) { sim.restore(snapshot); });
      },
      nb::arg("env"), nb::arg("snapshot"),
      "Puts one environment where this or another environment or Simulation of the scenario was.");
  c.def(
      "hash",
      [](PythonSimulationPool& pool, int env) {
        return with_env(pool, env, [](Simulation& sim) { return sim.hash(); });
      },
      nb::arg("env"), "64-bit hash over all transitions of one environment.");
}

}  // namespace

void bind_simulation_pool(nb::module_& m) {
  Class c(
      m, "SimulationPool",
      "Environments under direct control, shared out among threads. What steps or resets "
      "environments\n"
      "runs on all threads, without the GIL, waits for all environments, and then raises what the\n"
      "first of them met, with its number. For learning at speed take make_vec or make_pool.\n"
      "One Python thread at a time: a call while another is inside one raises Error.");
  c.def("__init__", &construct, nb::arg("compiled"), nb::arg("num_envs"), nb::arg("seed") = 0,
        nb::arg("first_env_id") = 0, nb::arg("pin_threads") = false, nb::arg("num_threads") = 0,
        "num_envs: N >= 1\n"
        "seed, first_env_id: environment i draws with the key (seed, first_env_id + i)\n"
        "pin_threads: give each worker a processor of its own where the system allows it; the\n"
        "    caller is left where it is\n"
        "num_threads: the caller counted; 0: one per processor\n\n"
        "Raises ValueError if a number is out of range.");
  bind_flow(c);
  bind_states(c);
  bind_one_env(c);
  c.def_prop_ro("compiled", &PythonSimulationPool::compiled, nb::rv_policy::reference_internal,
                "The scenario that it steps.");
  c.def_prop_ro("num_envs", &PythonSimulationPool::size, "N: number of environments.");
  c.def_prop_ro("num_threads", &PythonSimulationPool::threads,
                "Threads that step, the caller counted.");
  c.def_prop_ro("pinned_threads", &PythonSimulationPool::pinned_threads,
                "Workers kept on a processor; 0 where pinning is not allowed.");
  c.def_prop_ro("closed", &PythonSimulationPool::closed, "Whether close() was called.");
  def_unpicklable(c, &refuse_pickling);
}

}  // namespace skybody::python
