#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <new>
#include <tuple>

#include "core/env/setup_tables.h"
#include "python/native/bindings.h"
#include "python/native/environment.h"

namespace skybody::python {
namespace {

/// A channel with its place in the row.
struct PlacedChannel {
  std::string name, unit;
  int first = 0, count = 0;
  double low = 0.0, high = 0.0;
  int robot = -1;
};

/// What one robot's part of an action row means.
struct ActionChannel {
  int robot = 0;
  std::string signal;
  int first = 0, count = 0;
  std::vector<double> low, high;
};

std::vector<PlacedChannel> placed(const std::vector<Channel>& channels) {
  std::vector<PlacedChannel> list;
  int first = 0;
  for (const Channel& c : channels) {
    list.push_back({c.name, c.unit, first, c.count, c.low, c.high, c.robot});
    first += c.count;
  }
  return list;
}

std::vector<ActionChannel> action_channels(const Environment& environment) {
  std::vector<ActionChannel> list;
  for (const int robot : environment.agents()) {
    const ControllerChain& chain = environment.chains()[static_cast<std::size_t>(robot)];
    const PluginInstance& c = environment.controllers()[static_cast<std::size_t>(chain.first)];
    list.push_back(
        {robot, signal_name(c.input_signal), chain.action, c.input_count(), c.low, c.high});
  }
  return list;
}

std::vector<std::string> robot_names(const Environment& environment) {
  std::vector<std::string> names;
  for (const RobotUse& robot : environment.scenario().robots) names.push_back(robot.name);
  return names;
}

std::vector<std::string> param_paths(const Environment& environment) {
  std::vector<std::string> paths;
  for (const EnvParam& p : environment.layout().param_info) paths.push_back(p.path);
  return paths;
}

void bind_channels(nb::module_& m) {
  nb::class_<PlacedChannel>(m, "Channel", "A named part of an observation or info row.")
      .def_ro("name", &PlacedChannel::name, "Name, such as `position_error`.")
      .def_ro("unit", &PlacedChannel::unit, "SI unit; empty for a pure number.")
      .def_ro("first", &PlacedChannel::first, "Index of its first value within the row.")
      .def_ro("count", &PlacedChannel::count, "Number of values.")
      .def_ro("low", &PlacedChannel::low, "Least value that it takes; may be -inf.")
      .def_ro("high", &PlacedChannel::high, "Greatest value that it takes; may be inf.")
      .def_ro("robot", &PlacedChannel::robot,
              "Index of the robot whose own observation it belongs to; -1: every robot's.")
      .def("__repr__", [](const PlacedChannel& c) {
        return "Channel(" + c.name + "[" + std::to_string(c.count) + "] from " +
               std::to_string(c.first) + (c.unit.empty() ? "" : ", " + c.unit) + ")";
      });
  nb::class_<ActionChannel>(m, "ActionChannel",
                            "One robot's part of an action row: the input of its first controller.")
      .def_ro("robot", &ActionChannel::robot, "Index of the robot.")
      .def_ro("signal", &ActionChannel::signal,
              "What is commanded, such as `ctbr`: units and frames in docs/control-modes.md.")
      .def_ro("first", &ActionChannel::first, "Index of its first value within the row.")
      .def_ro("count", &ActionChannel::count, "Number of values.")
      .def_ro("low", &ActionChannel::low, "What the action -1 means, in the signal's units.")
      .def_ro("high", &ActionChannel::high, "What the action +1 means, in the signal's units.")
      .def("__repr__", [](const ActionChannel& c) {
        return "ActionChannel(" + c.signal + "[" + std::to_string(c.count) + "] of robot " +
               std::to_string(c.robot) + ")";
      });
}

void construct(LoadedEnvironment* self, const std::filesystem::path& scenario,
               std::vector<std::string> overrides, std::vector<std::filesystem::path> plugin_path) {
  new (self) LoadedEnvironment({scenario.string(), std::move(overrides), std::move(plugin_path)});
}

/// Pickled as what it was loaded from: the other process loads it again.
nb::tuple reduce(nb::handle self) {
  const LoadOptions& options = nb::cast<const LoadedEnvironment&>(self).options();
  std::vector<std::string> path;
  for (const auto& folder : options.plugin_path) path.push_back(folder.string());
  return nb::make_tuple(self.type(),
                        nb::make_tuple(options.scenario, options.overrides, std::move(path)));
}

void bind_identity(nb::class_<LoadedEnvironment>& c) {
  using E = LoadedEnvironment;
  c.def_prop_ro(
      "name", [](const E& e) { return e->scenario().name; }, "The scenario's name.");
  c.def_prop_ro(
      "file", [](const E& e) { return e->scenario().file; }, "The scenario's file.");
  c.def_prop_ro(
      "scenario_hash", [](const E& e) { return e->scenario().hash; },
      "64-bit hash over the merged scenario, model files and plugin parameters: equal "
      "hashes, equal worlds.");
  c.def_prop_ro(
      "scenario_text", [](const E& e) { return e->scenario().text; },
      "The scenario as YAML, fully merged: includes and overrides applied, defaults "
      "filled in.");
  c.def_prop_ro(
      "plugins", &E::plugins,
      "Versions of the plugins in use, by their names. Looks at the plugin folders anew.");
  c.def_prop_ro(
      "robots", [](const E& e) { return robot_names(*e); }, "Names of the robots.");
  c.def_prop_ro(
      "agents", [](const E& e) { return e->agents(); },
      "Indices of the robots that take actions: the agents of a multi-agent learner.");
  c.def("__repr__", [](const E& e) {
    return "Environment(" + e->scenario().name + ": " + std::to_string(e->action_size()) +
           " actions, " + std::to_string(e->observation_size()) + " observations)";
  });
}

void bind_time_and_spaces(nb::class_<LoadedEnvironment>& c) {
  using E = LoadedEnvironment;
  c.def_prop_ro(
      "dt", [](const E& e) { return e->scenario().stepping.dt; }, "Physics step [s].");
  c.def_prop_ro(
      "action_repeat", [](const E& e) { return e->scenario().stepping.action_repeat; },
      "K: physics steps of one step.");
  c.def_prop_ro(
      "horizon", [](const E& e) { return e->scenario().stepping.horizon; },
      "Steps until an episode is truncated; 0: never.");
  c.def_prop_ro(
      "gravity",
      [](const E& e) {
        const Vec3<double> g = e->scenario().gravity();
        return std::make_tuple(g.x, g.y, g.z);
      },
      "Acceleration of gravity, world axes (z up) [m/s^2].");
  c.def_prop_ro(
      "action_size", [](const E& e) { return e->action_size(); },
      "A: values of an action row, each in [-1, 1].");
  c.def_prop_ro(
      "observation_size", [](const E& e) { return e->observation_size(); },
      "O: values of an observation row.");
  c.def_prop_ro(
      "info_size", [](const E& e) { return e->info_size(); }, "I: values of an info row.");
  c.def_prop_ro(
      "observation_channels", [](const E& e) { return placed(e->task().channels); },
      "What an observation row consists of, in order.");
  c.def_prop_ro(
      "info_channels", [](const E& e) { return placed(e->task().infos); },
      "What an info row consists of, in order.");
  c.def_prop_ro(
      "action_channels", [](const E& e) { return action_channels(*e); },
      "What an action row consists of, one channel per agent.");
}

void bind_params(nb::class_<LoadedEnvironment>& c) {
  using E = LoadedEnvironment;
  c.def_prop_ro(
      "param_paths", [](const E& e) { return param_paths(*e); },
      "Paths of all randomizable parameters, such as robots.quad.links.base_link.mass.");
  c.def(
      "param_info",
      [](const E& e, const std::string& path) {
        const EnvParam& p = e.param(path);
        return std::make_tuple(p.nominal, p.min, p.max, p.unit);
      },
      nb::arg("path"),
      "Nominal value, least and greatest value that may be drawn, and unit.\n\n"
      "Raises ValueError if there is no such parameter.");
}

}  // namespace

void bind_environment(nb::module_& m) {
  bind_channels(m);
  nb::class_<LoadedEnvironment> c(m, "Environment",
                                  "One scenario, loaded: immutable, shared by the pools and "
                                  "simulations that are made of it.");
  c.def("__init__", &construct, nb::arg("scenario"),
        nb::arg("overrides") = std::vector<std::string>(),
        nb::arg("plugin_path") = std::vector<std::filesystem::path>(),
        nb::sig("def __init__(self, scenario: str | os.PathLike[str], overrides: "
                "collections.abc.Sequence[str] = (), plugin_path: "
                "collections.abc.Sequence[str | os.PathLike[str]] = ()) -> None"),
        "Loads a scenario; other Python threads run meanwhile.\n\n"
        "scenario: YAML file, or the name of a shipped scenario such as `hover`\n"
        "overrides: `PATH=VALUE` each, applied in order, as for `skybody run --set`\n"
        "plugin_path: folders with plugins, searched before SKYBODY_PLUGIN_PATH and the shipped\n"
        "    ones; the scenario's own folder is not searched\n\n"
        "Raises InputError (a ValueError) with every mistake as file:line:column.");
  c.def("__reduce__", &reduce, nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
  bind_identity(c);
  bind_time_and_spaces(c);
  bind_params(c);
}

}  // namespace skybody::python
