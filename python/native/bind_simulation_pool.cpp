#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <new>
#include <optional>
#include <string>
#include <vector>

#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/direct_control.h"
#include "python/native/simulation_pool.h"
#include "python/native/state_array.h"

namespace skybody::python {
namespace {

using Class = nb::class_<WorldPool>;

/// The worlds that a call is about: numbers, or all of them for None. Read under the GIL.
std::vector<int> read_worlds(const WorldPool& pool, nb::handle worlds) {
  std::vector<int> out;
  if (worlds.is_none()) {
    for (int i = 0; i < pool.size(); ++i) out.push_back(i);
  } else {
    const auto ids = read_array<std::int32_t>(worlds, "worlds", {-1});
    out.assign(ids.span().begin(), ids.span().end());
  }
  return out;
}

/// The first mistake in the numbers is the argument's, whatever comes later is the engine's.
void check_worlds(const WorldPool& pool, const std::vector<int>& worlds) {
  blame_argument([&] { check_indices("world", worlds, pool.size()); });
}

std::vector<int> chosen(const WorldPool& pool, nb::handle worlds) {
  std::vector<int> out = read_worlds(pool, worlds);
  check_worlds(pool, out);
  return out;
}

void construct(WorldPool* self, const LoadedEnvironment& environment, int num_worlds,
               std::uint64_t seed, std::uint64_t first_env_id, bool pin_threads, int num_threads) {
  new (self) WorldPool(environment, {num_worlds, seed, first_env_id, pin_threads, num_threads});
}

void reset(WorldPool& pool, nb::handle worlds, std::optional<std::uint64_t> seed) {
  const auto ids = chosen(pool, worlds);
  pool.call([&](SimulationPool& p) { seed ? p.reset(ids, *seed) : p.reset(ids); });
}

void step(WorldPool& pool, nb::handle actions, nb::handle worlds) {
  const auto ids = chosen(pool, worlds);
  const auto rows =
      read_array<float>(actions, "actions",
                        {static_cast<std::int64_t>(ids.size()), pool.environment()->action_size()});
  pool.call([&](SimulationPool& p) { p.step(ids, rows.span()); });
}

void command(WorldPool& pool, nb::handle values, const std::string& robot, nb::handle worlds) {
  const auto ids = chosen(pool, worlds);
  const int width = pool.call([&](SimulationPool& p) {
    return blame_argument([&] { return p.world(0).command_size(robot); });
  });
  const auto rows =
      read_array<double>(values, "values", {static_cast<std::int64_t>(ids.size()), width});
  pool.call(
      [&](SimulationPool& p) { blame_argument([&] { p.command(ids, robot, rows.span()); }); });
}

void advance(WorldPool& pool, std::int64_t steps, nb::handle worlds) {
  const auto ids = chosen(pool, worlds);
  advance_in_pieces(steps, [&](std::int64_t piece) {
    pool.call([&](SimulationPool& p) { p.advance(ids, piece); });
    return true;
  });
}

/// Values of all worlds after one another, `width` from each.
template <class T, class Write>
std::vector<T> gather(WorldPool& pool, std::size_t width, Write&& write) {
  std::vector<T> values(static_cast<std::size_t>(pool.size()) * width);
  pool.call([&](SimulationPool& p) {
    for (const int i : p.all()) {
      write(p.world(i), values.data() + static_cast<std::size_t>(i) * width);
    }
  });
  return values;
}

nb::object state(WorldPool& pool, const std::string& path) {
  return state_array(pool.environment(), path, {static_cast<std::size_t>(pool.size())},
                     [&](std::vector<double>& values) {
                       pool.call([&](SimulationPool& p) { p.state(path, values); });
                     });
}

nb::object observations(WorldPool& pool) {
  const auto width = static_cast<std::size_t>(pool.environment()->observation_size());
  const auto values = gather<float>(pool, width, [](Simulation& world, float* out) {
    std::copy(world.observation().begin(), world.observation().end(), out);
  });
  return copy_of<float>(values, {static_cast<std::size_t>(pool.size()), width});
}

/// One value of each world. @tparam T  of the array
template <class T, class Value>
nb::object each_value(WorldPool& pool, Value&& value) {
  const auto values = gather<T>(pool, 1, [&](Simulation& world, T* out) { *out = value(world); });
  return copy_of<T>(values, {static_cast<std::size_t>(pool.size())});
}

nb::object refuse_pickling(const WorldPool&) {
  throw nb::type_error(
      "a SimulationPool cannot be pickled or copied: it has threads. Make one anew in the other "
      "process, from the scenario and the seed");
}

constexpr const char* kWorldsText = "worlds: (n,) int32, each at most once; None: all in order\n\n";

void bind_flow(Class& c) {
  c.def("reset", &reset, nb::arg("worlds") = nb::none(), nb::arg("seed") = nb::none(),
        nb::sig("def reset(self, worlds: numpy.typing.NDArray[numpy.int32] | None = None, seed: "
                "int | None = None) -> None"),
        (std::string(
             "Begins the next episode of some worlds, or with a seed episode 1 under it.\n\n") +
         kWorldsText + "Raises ValueError if a number is out of range or twice there.")
            .c_str());
  c.def("step", &step, nb::arg("actions").none(), nb::arg("worlds") = nb::none(),
        nb::sig("def step(self, actions: numpy.typing.NDArray[numpy.float32], worlds: "
                "numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        (std::string(
             "One step of each: action_repeat physics steps. An ended episode goes on until it is\n"
             "reset.\n\n"
             "actions: (n, A) float32 in [-1, 1] (clipped)\n") +
         kWorldsText +
         "Raises TypeError on another dtype, ValueError on another shape, Error before reset().")
            .c_str());
  c.def("command", &command, nb::arg("values").none(), nb::arg("robot") = "",
        nb::arg("worlds") = nb::none(),
        nb::sig("def command(self, values: numpy.typing.NDArray[numpy.float64], robot: str = "
                "\"\", worlds: numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        (std::string("Sets the input of a robot's first controller, as Simulation.command.\n\n"
                     "values: (n, command_size) float64, in the signal's units\n") +
         kWorldsText + "Raises ValueError likewise, and before reset().")
            .c_str());
  c.def("advance", &advance, nb::arg("physics_steps") = 1, nb::arg("worlds") = nb::none(),
        nb::sig("def advance(self, physics_steps: int = 1, worlds: "
                "numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
        (std::string(
             "Physics steps of each under its commands. A world whose physics gives up ends its\n"
             "episode as a fault (`status`). KeyboardInterrupt gets through.\n\n") +
         kWorldsText + "Raises ValueError if physics_steps < 0, Error before reset().")
            .c_str());
  c.def(
      "evaluate",
      [](WorldPool& pool, nb::handle worlds) {
        const auto ids = chosen(pool, worlds);
        pool.call([&](SimulationPool& p) { p.evaluate(ids); });
      },
      nb::arg("worlds") = nb::none(),
      nb::sig(
          "def evaluate(self, worlds: numpy.typing.NDArray[numpy.int32] | None = None) -> None"),
      "Ends a transition made by command and advance, as Simulation.evaluate.");
  c.def("close", &WorldPool::close,
        "Ends the threads. May be called again; any other call raises Error from then on.");
  c.def(
      "__enter__", [](nb::handle_t<WorldPool> self) { return nb::borrow(self); },
      nb::sig("def __enter__(self) -> SimulationPool"));
  c.def(
      "__exit__", [](WorldPool& pool, const nb::args&) { pool.close(); },
      nb::sig("def __exit__(self, *exception: object) -> None"));
}

void bind_states(Class& c) {
  c.def("state", &state, nb::arg("path"),
        nb::sig("def state(self, path: str) -> numpy.typing.NDArray[numpy.float64]"),
        "A value of the state of all worlds, (num_worlds, *shape) float64, fresh. What there is, "
        "with\n"
        "units, frames and shapes: Environment.state_values.\n\n"
        "Raises ValueError naming the nearest paths if there is none.");
  c.def_prop_ro(
      "positions", [](WorldPool& p) { return state(p, "bodies.position"); },
      nb::sig("def positions(self) -> numpy.typing.NDArray[numpy.float64]"),
      "(num_worlds, bodies, 3) float64, fresh: origins, world axes [m].");
  c.def_prop_ro(
      "rotations", [](WorldPool& p) { return state(p, "bodies.rotation"); },
      nb::sig("def rotations(self) -> numpy.typing.NDArray[numpy.float64]"),
      "(num_worlds, bodies, 4) float64, fresh: unit quaternions w x y z, world from body.");
  c.def_prop_ro(
      "velocities", [](WorldPool& p) { return state(p, "bodies.velocity"); },
      nb::sig("def velocities(self) -> numpy.typing.NDArray[numpy.float64]"),
      "(num_worlds, bodies, 3) float64, fresh: of the origins, world axes [m/s].");
  c.def_prop_ro(
      "angular_velocities", [](WorldPool& p) { return state(p, "bodies.angular_velocity"); },
      nb::sig("def angular_velocities(self) -> numpy.typing.NDArray[numpy.float64]"),
      "(num_worlds, bodies, 3) float64, fresh: body axes [rad/s].");
  c.def_prop_ro(
      "rotor_speeds", [](WorldPool& p) { return state(p, "rotor_speed"); },
      nb::sig("def rotor_speeds(self) -> numpy.typing.NDArray[numpy.float64]"),
      "(num_worlds, rotors) float64, fresh [rad/s].");
  c.def_prop_ro(
      "times", [](WorldPool& p) { return state(p, "time"); },
      nb::sig("def times(self) -> numpy.typing.NDArray[numpy.float64]"),
      "(num_worlds,) float64: since each world's reset [s].");
  c.def_prop_ro("observations", &observations,
                nb::sig("def observations(self) -> numpy.typing.NDArray[numpy.float32]"),
                "(num_worlds, O) float32, fresh: of the scenario's task, after the last reset,\n"
                "step or evaluate.");
  c.def_prop_ro(
      "rewards",
      [](WorldPool& p) {
        return each_value<float>(p, [](Simulation& world) { return world.reward(); });
      },
      nb::sig("def rewards(self) -> numpy.typing.NDArray[numpy.float32]"),
      "(num_worlds,) float32: of the scenario's task, likewise.");
  c.def_prop_ro(
      "status",
      [](WorldPool& p) {
        return each_value<std::uint64_t>(p, [](Simulation& world) { return world.status(); });
      },
      nb::sig("def status(self) -> numpy.typing.NDArray[numpy.uint64]"),
      "(num_worlds,) uint64: bits of the last transition: 1 terminated, 2 truncated, 4 fault.");
}

/// Calls work(Simulation&) for one world. @throws ValueError if there is none of that number
template <class Work>
decltype(auto) with_world(WorldPool& pool, int world, Work&& work) {
  check_worlds(pool, {world});
  return pool.call(
      [&](SimulationPool& p) { return blame_argument([&] { return work(p.world(world)); }); });
}

void bind_one_world(Class& c) {
  c.def(
      "teleport",
      [](WorldPool& pool, int world, nb::handle position, nb::handle rotation, nb::handle velocity,
         nb::handle angular_velocity, const std::string& robot) {
        const NewMotion motion(position, rotation, velocity, angular_velocity);
        with_world(pool, world, [&](Simulation& sim) {
          sim.teleport(robot, motion.applied_to(sim.base(robot)));
        });
      },
      nb::arg("world"), nb::arg("position") = nb::none(), nb::arg("rotation") = nb::none(),
      nb::arg("velocity") = nb::none(), nb::arg("angular_velocity") = nb::none(),
      nb::arg("robot") = "",
      nb::sig("def teleport(self, world: int, position: numpy.typing.NDArray[numpy.float64] | None "
              "= None, rotation: numpy.typing.NDArray[numpy.float64] | None = None, velocity: "
              "numpy.typing.NDArray[numpy.float64] | None = None, angular_velocity: "
              "numpy.typing.NDArray[numpy.float64] | None = None, robot: str = \"\") -> None"),
      "Simulation.teleport in one world.");
  c.def(
      "param",
      [](WorldPool& pool, int world, const std::string& path) {
        return with_world(pool, world, [&](Simulation& sim) { return sim.param(path); });
      },
      nb::arg("world"), nb::arg("path"), "Simulation.param of one world.");
  c.def(
      "set_param",
      [](WorldPool& pool, int world, const std::string& path, double value) {
        with_world(pool, world, [&](Simulation& sim) { sim.set_param(path, value); });
      },
      nb::arg("world"), nb::arg("path"), nb::arg("value"), "Simulation.set_param in one world.");
  c.def(
      "save",
      [](WorldPool& pool, int world) {
        return with_world(pool, world, [](Simulation& sim) { return sim.save(); });
      },
      nb::arg("world"), "Simulation.save of one world.");
  c.def(
      "restore",
      [](WorldPool& pool, int world, const Snapshot& snapshot) {
        with_world(pool, world, [&](Simulation& sim) { sim.restore(snapshot); });
      },
      nb::arg("world"), nb::arg("snapshot"),
      "Puts one world where this or another world or Simulation of the scenario was.");
  c.def(
      "hash",
      [](WorldPool& pool, int world) {
        return with_world(pool, world, [](Simulation& sim) { return sim.hash(); });
      },
      nb::arg("world"), "64-bit hash over all transitions of one world.");
}

}  // namespace

void bind_simulation_pool(nb::module_& m) {
  Class c(m, "SimulationPool",
          "Worlds under direct control, shared out among threads. What steps or resets worlds\n"
          "runs on all threads, without the GIL, waits for all worlds, and then raises what the\n"
          "first of them met, with its number. For learning at speed take make_vec or make_pool.\n"
          "One Python thread at a time: a call while another is inside one raises Error.");
  c.def("__init__", &construct, nb::arg("environment"), nb::arg("num_worlds"), nb::arg("seed") = 0,
        nb::arg("first_env_id") = 0, nb::arg("pin_threads") = false, nb::arg("num_threads") = 0,
        "num_worlds: N >= 1\n"
        "seed, first_env_id: world i draws with the key (seed, first_env_id + i)\n"
        "pin_threads: give each worker a processor of its own where the system allows it; the\n"
        "    caller is left where it is\n"
        "num_threads: the caller counted; 0: one per processor\n\n"
        "Raises ValueError if a number is out of range.");
  bind_flow(c);
  bind_states(c);
  bind_one_world(c);
  c.def_prop_ro("environment", &WorldPool::environment, nb::rv_policy::reference_internal,
                "The scenario that it steps.");
  c.def_prop_ro("num_worlds", &WorldPool::size, "N: number of worlds.");
  c.def_prop_ro("num_threads", &WorldPool::threads, "Threads that step, the caller counted.");
  c.def_prop_ro("pinned_threads", &WorldPool::pinned_threads,
                "Workers kept on a processor; 0 where pinning is not allowed.");
  c.def_prop_ro("closed", &WorldPool::closed, "Whether close() was called.");
  c.def("__reduce__", &refuse_pickling, nb::sig("def __reduce__(self) -> typing.NoReturn"));
}

}  // namespace skybody::python
