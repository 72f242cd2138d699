#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/errors.h"
#include "python/native/properties.h"
#include "python/native/simulation.h"
#include "python/native/state_array.h"

namespace skybody::python {
namespace {

using S = DirectSimulation;
using Class = nb::class_<S>;

nb::object row(std::span<const float> values) { return copy_of(values, {values.size()}); }

nb::object row(const std::vector<double>& values) {
  return copy_of<double>(values, {values.size()});
}

/// A function of Python that returns an array of the values of one of the simulation.
template <class Result>
auto row_of(Result (Simulation::*member)() const) {
  return [member](S& s) { return s.look([&](Simulation& sim) { return row((sim.*member)()); }); };
}

void construct(S* self, const LoadedScenario& compiled, std::uint64_t seed, std::uint64_t env_id) {
  new (self) S(compiled, Simulation(compiled.shared(), seed, env_id));
}

void construct_by_name(S* self, const std::string& scenario, std::uint64_t seed,
                       std::uint64_t env_id) {
  construct(self, LoadedScenario({scenario, {}, {}}), seed, env_id);
}

void reset(S& s, std::optional<std::uint64_t> seed) {
  s.call([&](Simulation& sim) { seed ? sim.reset(*seed) : sim.reset(); });
}

void step(S& s, nb::handle action) {
  const auto values = read_array<float>(action, "action", {s.compiled()->action_size()});
  s.call([&](Simulation& sim) { sim.step(values.span()); });
}

S* fork(S& s, bool rekey) {
  return new S(s.compiled(), s.call([&](Simulation& sim) { return sim.fork(rekey); }));
}

nb::object refuse_pickling(const S&) {
  throw nb::type_error(
      "a Simulation cannot be pickled: make one anew in the other process, from the scenario, the "
      "seed and the env_id, or copy it in this process with fork()");
}

void bind_body(nb::module_& m) {
  nb::class_<BodyState>(m, "BodyState", "Position and motion of a body's frame.")
      .def_prop_ro(
          "position", [](const BodyState& b) { return vector3(b.position); },
          nb::sig("def position(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: origin, world axes (z up) [m].")
      .def_prop_ro(
          "rotation",
          [](const BodyState& b) {
            const double q[] = {b.rotation.w, b.rotation.x, b.rotation.y, b.rotation.z};
            return copy_of<double>(q, {4});
          },
          nb::sig("def rotation(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(4,) float64: unit quaternion w x y z, world from body.")
      .def_prop_ro(
          "velocity", [](const BodyState& b) { return vector3(b.velocity); },
          nb::sig("def velocity(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: of the origin, world axes [m/s].")
      .def_prop_ro(
          "angular_velocity", [](const BodyState& b) { return vector3(b.angular_velocity); },
          nb::sig("def angular_velocity(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: body axes (x forward, y left, z up) [rad/s].");
}

template <class T>
nb::bytes bytes_of(const std::vector<T>& values) {
  return nb::bytes(values.data(), values.size() * sizeof(T));
}

template <class T>
void read(const nb::bytes& bytes, std::vector<T>& values) {
  values.resize(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
}

/// Content of a pickled Snapshot, in the order of its members.
using SnapshotState = std::tuple<std::uint64_t, nb::bytes, nb::bytes, nb::bytes, nb::bytes,
                                 nb::bytes, float, nb::bytes, bool>;

SnapshotState snapshot_state(const Snapshot& s) {
  return {s.scenario_hash,
          bytes_of(s.words),
          bytes_of(s.observation),
          bytes_of(s.agent_rewards),
          bytes_of(s.info),
          bytes_of(s.privileged),
          s.reward,
          bytes_of(std::vector{s.trajectory}),
          s.started};
}

void set_snapshot_state(Snapshot& s, const SnapshotState& state) {
  new (&s) Snapshot;
  s.scenario_hash = std::get<0>(state);
  read(std::get<1>(state), s.words);
  read(std::get<2>(state), s.observation);
  read(std::get<3>(state), s.agent_rewards);
  read(std::get<4>(state), s.info);
  read(std::get<5>(state), s.privileged);
  s.reward = std::get<6>(state);
  std::vector<HashChain> chain;
  read(std::get<7>(state), chain);
  s.trajectory = chain.at(0);
  s.started = std::get<8>(state);
}

void bind_snapshot(nb::module_& m) {
  nb::class_<Snapshot>(m, "Snapshot", "Everything of one simulation; for restore().")
      .def_ro("scenario_hash", &Snapshot::scenario_hash, "Which scenario it is of.")
      .def("__getstate__", &snapshot_state)
      .def("__setstate__", &set_snapshot_state);
}

void bind_flow(Class& c) {
  c.def("reset", &reset, nb::arg("seed") = nb::none(),
        "Begins the next episode, or with a seed episode 1 under that seed.");
  c.def(
      "step", &step, nb::arg("action").none(),
      nb::sig("def step(self, action: numpy.typing.NDArray[numpy.float32]) -> None"),
      "One step: action_repeat physics steps.\n\n"
      "action: (A,) float32 in [-1, 1] (clipped); a non-finite one ends the episode as a fault\n\n"
      "Raises TypeError on another dtype, ValueError on another shape, Error before reset().");
  c.def(
      "randomize", [](S& s) { s.call([](Simulation& sim) { sim.randomize(); }); },
      "Draws from all randomizers now, in mid-episode; motion goes on.");
  c.def("save", of(&Simulation::save),
        "Everything: motion, rotors, drawn values, plugin states, counters, random key.");
  c.def(
      "restore",
      [](S& s, const Snapshot& saved) {
        rethrow_as_argument_error([&] { s.look([&](Simulation& sim) { sim.restore(saved); }); });
      },
      nb::arg("snapshot"), "Puts it back. Raises ValueError if it is of another scenario.");
  c.def("fork", &fork, nb::arg("rekey") = false, nb::rv_policy::take_ownership,
        "A copy with the same future; with `rekey` its random numbers are its own.");
  c.def("hash", of(&Simulation::hash), "64-bit hash over all transitions so far.");
}

void bind_outcome(Class& c) {
  def_array(c, "observation", "float32", row_of(&Simulation::observation),
            "(O,) float32, a copy: after the last reset or step.");
  def_array(c, "privileged", "float32", row_of(&Simulation::privileged),
            "(P,) float32, a copy: likewise, what a critic sees besides.");
  c.def(
      "image_bytes",
      [](S& s, int image) {
        return s.look([&](Simulation& sim) {
          return array_of<std::uint8_t>(
              rethrow_as_argument_error([&] { return sim.image(image); }));
        });
      },
      nb::arg("image"),
      nb::sig("def image_bytes(self, image: int) -> numpy.typing.NDArray[numpy.uint8]"),
      "(bytes,) uint8, a copy: the memory of skybody.Simulation.image().");
  c.def_prop_ro("reward", of(&Simulation::reward), "Of the last step; of a team, the team's.");
  def_array(c, "agent_rewards", "float32", row_of(&Simulation::agent_rewards),
            "(agents,) float32: each agent's own; the team's where the task gives no own.");
  def_array(c, "info", "float32", row_of(&Simulation::info),
            "(I,) float32: info values (the task's, then what other plugins report), as\n"
            "CompiledScenario.info_channels names them.");
  c.def_prop_ro("terminated", of(&Simulation::terminated), "Whether the task ended the episode.");
  c.def_prop_ro("truncated", of(&Simulation::truncated),
                "Whether horizon, task or fault ended it.");
  c.def_prop_ro("fault", of(&Simulation::fault),
                "Whether a bad action, state or outcome ended it (fault_reason).");
  c.def_prop_ro(
      "fault_reason",
      [](S& s) -> std::optional<std::string> {
        const std::uint64_t status = s.look([](Simulation& sim) { return sim.status(); });
        if ((status & kFault) == 0) return std::nullopt;
        return s.compiled()->fault_reason(status);
      },
      "Why it is a fault, with body and value where they are known; None where it is none.");
  c.def_prop_ro("status", of(&Simulation::status), "Bits of the last transition, as Batch.status.");
  c.def_prop_ro("episode", of(&Simulation::episode), "1 in the first.");
  c.def_prop_ro("steps", of(&Simulation::steps), "Actions taken in this episode.");
  c.def_prop_ro("time", of(&Simulation::time), "Since the reset [s].");
}

void bind_motion(Class& c) {
  c.def(
      "body",
      [](S& s, const std::string& link, const std::string& robot) {
        return s.look([&](Simulation& sim) {
          return rethrow_as_argument_error([&]() -> BodyState { return sim.body(robot, link); });
        });
      },
      nb::arg("link"), nb::arg("robot") = "",
      "Motion of the body that a link belongs to; `robot` may be left out where there is one.\n\n"
      "Raises ValueError naming the robots or links that there are.");
  c.def_prop_ro("bodies", of(&Simulation::bodies),
                "Motion of all bodies, in the world's numbering.");
  def_array(c, "rotor_speeds", "float64", row_of(&Simulation::rotor_speeds),
            "(rotors,) float64, a copy [rad/s].");
  def_array(c, "rotor_commands", "float64", row_of(&Simulation::rotor_commands),
            "(rotors,) float64, a copy: references held during the last physics step [rad/s].");
  def_array(c, "commands", "float64", row_of(&Simulation::commands),
            "float64, a copy: commands of all chains of controllers, in their signals' units.");
  def_array(c, "sensors", "float64", row_of(&Simulation::sensors),
            "float64, a copy: outputs of all sensors, in the scenario's order.");
  def_array(c, "goals", "float64", row_of(&Simulation::goals),
            "(4 * goals,) float64, a copy: where the task wants its bodies, position (world) "
            "[m] and yaw [rad] each.");
  def_array(c, "goal_motions", "float64", row_of(&Simulation::goal_motions),
            "(6 * goals,) float64, a copy: how these places move, velocity (world) [m/s] and "
            "acceleration "
            "(world) [m/s^2] each; 0 where the task does not say.");
}

void bind_params(Class& c) {
  c.def(
      "state",
      [](S& s, const std::string& path) {
        return state_array(s.compiled(), path, {}, [&](std::vector<double>& values) {
          values = s.look([&](Simulation& sim) { return sim.state(path); });
        });
      },
      nb::arg("path"), nb::sig("def state(self, path: str) -> numpy.typing.NDArray[numpy.float64]"),
      "A value of the state, float64, fresh; () for a single number. What there is, with units,\n"
      "frames and shapes: CompiledScenario.state_values.\n\n"
      "Raises ValueError naming the nearest paths if there is none.");
  c.def("param", of(&Simulation::param), nb::arg("path"),
        "Value of a randomizable parameter; units in CompiledScenario.param_info.\n\n"
        "Raises ValueError if there is none.");
  c.def(
      "set_param",
      [](S& s, const std::string& path, double value) {
        s.look([&](Simulation& sim) {
          rethrow_as_argument_error([&] { sim.set_param(path, value); });
        });
      },
      nb::arg("path"), nb::arg("value"),
      "Sets it, in mid-episode.\n\nRaises ValueError if unknown or outside its bounds.");
  c.def(
      "request_lines",
      [](S& s, const std::vector<std::string>& lines, bool at_reset) {
        s.look([&](Simulation& sim) {
          rethrow_as_argument_error([&] {
            sim.request(read_param_changes(lines),
                        at_reset ? RequestTime::kNextReset : RequestTime::kNextStep);
          });
        });
      },
      nb::arg("lines"), nb::arg("at_reset"), "What skybody.Simulation.request() hands over.");
}

}  // namespace

void bind_simulation(nb::module_& m) {
  bind_body(m);
  bind_snapshot(m);
  Class c(m, "Simulation",
          "One environment under direct control. One Python thread at a time; several Simulations "
          "are\nindependent.");
  c.def("__init__", &construct, nb::arg("compiled"), nb::arg("seed") = 0, nb::arg("env_id") = 0,
        "seed, env_id: key of all random numbers; equal keys, equal draws.");
  c.def("__init__", &construct_by_name, nb::arg("scenario"), nb::arg("seed") = 0,
        nb::arg("env_id") = 0,
        "scenario: YAML file or name of a shipped one.\n\nRaises InputError (a ValueError).");
  c.def_prop_ro("compiled", &S::compiled, nb::rv_policy::reference_internal,
                "The scenario that it steps.");
  bind_flow(c);
  bind_outcome(c);
  bind_motion(c);
  bind_params(c);
  bind_direct_control(m, c);
  def_unpicklable(c, &refuse_pickling);
}

}  // namespace skybody::python
