#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <new>
#include <tuple>

#include "core/env/plugin_setup_tables.h"
#include "core/env/state_values.h"
#include "core/env/value_names.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/loaded_scenario.h"
#include "python/native/shapes.h"

namespace skybody::python {
namespace {

/// A channel with its place in the row.
struct PlacedChannel {
  std::string name, unit;
  int first = 0, count = 0;
  double low = 0.0, high = 0.0;
  int robot = -1;
  std::string doc;
};

std::vector<PlacedChannel> placed(const std::vector<Channel>& channels) {
  std::vector<PlacedChannel> list;
  int first = 0;
  for (const Channel& c : channels) {
    list.push_back({c.name, c.unit, first, c.count, c.low, c.high, c.robot, c.doc});
    first += c.count;
  }
  return list;
}

/// The columns of an observation row, as channels with their places.
std::vector<PlacedChannel> observation_channels(const CompiledScenario& compiled) {
  std::vector<PlacedChannel> list;
  for (const ObservationColumn& c : compiled.columns()) {
    if (c.privileged || c.image >= 0) continue;
    list.push_back({c.name, c.unit, c.first, c.count(), c.low, c.high, c.robot, c.doc});
  }
  return list;
}

/// A column with its source as text.
struct NamedColumn : ObservationColumn {
  std::string source;
};

std::vector<NamedColumn> observation_columns(const CompiledScenario& compiled) {
  std::vector<NamedColumn> list;
  for (const ObservationColumn& c : compiled.columns()) {
    list.push_back({c, source_of(compiled, c)});
  }
  return list;
}

std::vector<std::string> body_names(const CompiledScenario& compiled) {
  std::vector<std::string> names;
  for (const WorldBody& body : compiled.world().bodies) {
    const auto robot = static_cast<std::size_t>(body.robot);
    names.push_back(compiled.scenario().robots[robot].name + "." + body.model->name);
  }
  return names;
}

std::vector<std::string> robot_names(const CompiledScenario& compiled) {
  std::vector<std::string> names;
  for (const RobotUse& robot : compiled.scenario().robots) names.push_back(robot.name);
  return names;
}

std::map<std::string, std::string> sensors_of(const CompiledScenario& compiled) {
  std::map<std::string, std::string> sensors;
  for (const PluginUse& use : compiled.scenario().sensors) sensors[use.instance] = use.plugin;
  return sensors;
}

/// The values of a sensor's parameters, each as a list.
nb::dict sensor_parameters(const CompiledScenario& compiled, const std::string& name) {
  for (const PluginUse& use : compiled.scenario().sensors) {
    if (use.instance != name) continue;
    nb::dict parameters;
    for (const ParameterValue& value : use.parameters) {
      const bool is_text = value.type == ParameterType::kText;
      parameters[value.name.c_str()] = is_text ? nb::cast(value.texts) : nb::cast(value.numbers);
    }
    return parameters;
  }
  throw nb::value_error(("no sensor is called `" + name + "`").c_str());
}

std::vector<std::string> param_paths(const CompiledScenario& compiled) {
  std::vector<std::string> paths;
  for (const EnvParam& p : compiled.layout().param_info) paths.push_back(p.path);
  return paths;
}

void bind_column(nb::module_& m) {
  using C = NamedColumn;
  nb::class_<C>(m, "ObservationColumn", "A part of the observation with a type and a shape.")
      .def_ro("name", &C::name, "Name, such as `velocity`.")
      .def_ro("unit", &C::unit, "SI unit; empty for a pure number.")
      .def_ro("doc", &C::doc, "What the values are; empty: unsaid.")
      .def_prop_ro(
          "dtype", [](const C& c) { return info_of(c.type).name; },
          "NumPy's name of the type: `float32`, or of an image `uint8`, `uint16` as well.")
      .def_prop_ro(
          "shape", [](const C& c) { return nb::tuple(nb::cast(c.shape)); },
          nb::sig("def shape(self) -> tuple[int, ...]"), "Shape of one environment's value.")
      .def_ro("low", &C::low, "Least value; may be -inf.")
      .def_ro("high", &C::high, "Greatest value; may be inf.")
      .def_ro("robot", &C::robot,
              "Index of the robot whose own observation it belongs to; -1: every robot's.")
      .def_ro("privileged", &C::privileged,
              "Whether it is for a critic only: in Batch.privileged, not in Batch.observation.")
      .def_ro("source", &C::source, "`task`, or the sensor and its channel: `imu.angular_rate`.")
      .def_ro("first", &C::first,
              "Index of its first value within the row of observations, or the privileged row.")
      .def_ro("image", &C::image, "An image's index for Batch.image(); -1: it is part of a row.")
      .def("__repr__", [](const C& c) {
        return "ObservationColumn(" + c.name + " from " + c.source +
               (c.privileged ? ", privileged)" : ")");
      });
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
      .def_ro("doc", &PlacedChannel::doc, "What the values are; empty: unsaid.")
      .def("__repr__", [](const PlacedChannel& c) {
        return "Channel(" + c.name + "[" + std::to_string(c.count) + "] from " +
               std::to_string(c.first) + (c.unit.empty() ? "" : ", " + c.unit) + ")";
      });
  bind_column(m);
  nb::class_<ActionChannel>(m, "ActionChannel",
                            "A part of an action row: the command of one chain of controllers, or "
                            "a part that the task declares.")
      .def_ro("robot", &ActionChannel::robot, "Index of the robot.")
      .def_ro("name", &ActionChannel::name,
              "What is commanded: a signal such as `ctbr` (docs/control-modes.md), or the task's "
              "own word.")
      .def_ro("unit", &ActionChannel::unit, "SI unit of the task's own; else empty.")
      .def_ro("first", &ActionChannel::first, "Index of its first value within the row.")
      .def_prop_ro(
          "count", [](const ActionChannel& c) { return c.low.size(); }, "Number of values.")
      .def_ro("low", &ActionChannel::low, "What the action -1 means.")
      .def_ro("high", &ActionChannel::high, "What the action +1 means.")
      .def("__repr__", [](const ActionChannel& c) {
        return "ActionChannel(" + c.name + "[" + std::to_string(c.low.size()) + "] of robot " +
               std::to_string(c.robot) + ")";
      });
}

void bind_state_value(nb::module_& m) {
  using V = StateValue;
  nb::class_<V>(m, "StateValue", "What can be read of an environment's state at one path.")
      .def_ro("path", &V::path, "Such as robots.quad.base.position.")
      .def_ro("unit", &V::unit, "SI unit; empty for a pure number.")
      .def_prop_ro(
          "frame", [](const V& v) { return v.frame; },
          "Axes of vectors: `W` world (z up), `B` the body or link itself; `W from B` of a "
          "rotation; else empty.")
      .def_prop_ro(
          "shape", [](const V& v) { return nb::tuple(nb::cast(v.shape)); },
          nb::sig("def shape(self) -> tuple[int, ...]"),
          "Shape for one environment; empty for a single number.")
      .def_prop_ro(
          "doc", [](const V& v) { return v.doc; }, "Meaning, one line.")
      .def("__repr__", [](const V& v) {
        return "StateValue(" + v.path + (v.unit.empty() ? "" : " [" + v.unit + "]") + ")";
      });
}

void construct(LoadedScenario* self, const std::filesystem::path& scenario,
               std::vector<std::string> overrides, std::vector<std::filesystem::path> plugin_path) {
  new (self) LoadedScenario({scenario.string(), std::move(overrides), std::move(plugin_path)});
}

/// Pickled as its load options: the other process loads it again.
nb::tuple reduce(nb::handle self) {
  const LoadOptions& options = nb::cast<const LoadedScenario&>(self).options();
  std::vector<std::string> path;
  for (const auto& folder : options.plugin_path) path.push_back(folder.string());
  return nb::make_tuple(self.type(),
                        nb::make_tuple(options.scenario, options.overrides, std::move(path)));
}

/// The value of one of the scenario's functions.
template <auto value>
auto fact(const LoadedScenario& scenario) {
  return ((*scenario).*value)();
}

void bind_identity(nb::class_<LoadedScenario>& c) {
  using E = LoadedScenario;
  c.def_prop_ro(
      "name", [](const E& e) { return e->scenario().name; }, "The scenario's name.");
  c.def_prop_ro(
      "file", [](const E& e) { return e->scenario().file; }, "The scenario's file.");
  c.def_prop_ro(
      "scenario_hash", [](const E& e) { return e->scenario().hash; },
      "64-bit hash over the merged scenario, model files and plugin parameters: equal "
      "hashes, equal scenarios.");
  c.def_prop_ro(
      "scenario_text", [](const E& e) { return e->scenario().text; },
      "The scenario as YAML, fully merged: includes and overrides applied. Keys that are not\n"
      "given are not in it.");
  c.def_prop_ro(
      "plugins", &E::plugins,
      "Versions of the plugins in use, by their names. Looks at the plugin folders anew.");
  c.def_prop_ro(
      "robots", [](const E& e) { return robot_names(*e); }, "Names of the robots.");
  c.def_prop_ro(
      "bodies", [](const E& e) { return body_names(*e); },
      "ROBOT.LINK of all bodies, in the world's numbering.");
  c.def_prop_ro(
      "shapes", [](const E& e) { return shapes_of(*e); },
      "Collision shapes of all bodies, in body order, then the obstacles.");
  c.def_prop_ro(
      "obstacles", [](const E& e) { return obstacles_of(*e); },
      "The obstacles of the scenario, in its order.");
  c.def_prop_ro(
      "visuals", [](const E& e) { return visuals_of(*e); },
      "Shapes of bodies that are drawn, in body order: those of the URDF's `<visual>`, or the\n"
      "collision shapes of a body without any.\n\nRaises Error if a mesh cannot be read.");
  c.def_prop_ro(
      "rotors", [](const E& e) { return rotors_of(*e); }, "All rotors, robot by robot.");
  c.def_prop_ro(
      "couplings", [](const E& e) { return couplings_of(*e); },
      "The scenario's couplings, in its order.");
  c.def(
      "height_field_corners",
      [](const E& e, int obstacle) {
        const std::vector<float> corners = field_corners(*e, obstacle);
        return copy_of<float>(corners, {corners.size() / 9, 3, 3});
      },
      nb::arg("obstacle"),
      nb::sig("def height_field_corners(self, obstacle: int) -> numpy.ndarray"),
      "Corners of the triangles of a height field, in its frame [m]: (triangles, 3, 3) float32.\n\n"
      "obstacle: its place among the obstacles");
  c.def_prop_ro("agents", fact<&CompiledScenario::agents>,
                "Indices of the robots that take actions: the agents of a multi-agent learner.");
  c.def("__repr__", [](const E& e) {
    return "CompiledScenario(" + e->scenario().name + ": " + std::to_string(e->action_size()) +
           " actions, " + std::to_string(e->observation_size()) + " observations)";
  });
}

void bind_time_and_spaces(nb::class_<LoadedScenario>& c) {
  using E = LoadedScenario;
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
  c.def_prop_ro("action_size", fact<&CompiledScenario::action_size>,
                "A: values of an action row, each in [-1, 1].");
  c.def_prop_ro("observation_size", fact<&CompiledScenario::observation_size>,
                "O: values of an observation row.");
  c.def_prop_ro("privileged_size", fact<&CompiledScenario::privileged_size>,
                "P: values of a privileged row, which is for a critic only.");
  c.def_prop_ro("info_size", fact<&CompiledScenario::info_size>, "I: values of an info row.");
  c.def_prop_ro(
      "observation_channels", [](const E& e) { return observation_channels(*e); },
      "What a row of observations consists of, in order.");
  c.def_prop_ro(
      "observation_columns", [](const E& e) { return observation_columns(*e); },
      "All columns of the observation: the task's in order, then those that `observe` adds.");
  c.def_prop_ro(
      "info_channels", [](const E& e) { return placed(e->info_channels()); },
      "What an info row consists of, in order.");
  c.def_prop_ro("action_channels", fact<&CompiledScenario::action_channels>,
                "What an action row consists of, one channel per agent.");
}

void bind_sensors(nb::class_<LoadedScenario>& c) {
  using E = LoadedScenario;
  c.def_prop_ro(
      "sensors", [](const E& e) { return sensors_of(*e); },
      "Plugins of the sensors, by the sensors' names.");
  c.def(
      "sensor_parameters",
      [](const E& e, const std::string& name) { return sensor_parameters(*e, name); },
      nb::arg("name"),
      nb::sig("def sensor_parameters(self, name: str) -> dict[str, list[float] | list[str]]"),
      "The values of a sensor's parameters in the scenario, defaults included; true is 1.\n\n"
      "Raises ValueError if there is no such sensor.");
}

void bind_params(nb::class_<LoadedScenario>& c) {
  using E = LoadedScenario;
  c.def_prop_ro(
      "param_paths", [](const E& e) { return param_paths(*e); },
      "Paths of all randomizable parameters, such as robots.quad.links.base_link.mass.");
  c.def_prop_ro(
      "state_values",
      [](const E& e) {
        std::map<std::string, StateValue> values;
        for (const StateValue& value : e->state_values().all()) values[value.path] = value;
        return values;
      },
      nb::sig("def state_values(self) -> dict[str, StateValue]"),
      "What can be read of the state, by path.");
  c.def(
      "param_info",
      [](const E& e, const std::string& path) {
        const EnvParam& p = e.param(path);
        return std::make_tuple(p.nominal, p.min, p.max, p.unit);
      },
      nb::arg("path"),
      "Nominal value, least and greatest value that may be drawn, and unit.\n\n"
      "Raises ValueError if there is no such parameter.");
  c.def("check_vector", &E::check_vector, nb::arg("path"), nb::arg("count"),
        "What requests ask before they give a list of values to a path.\n\n"
        "Raises ValueError where the path names anything but vectors of `count` values.");
  c.def("check_one_value", &E::check_one_value, nb::arg("path"),
        "What requests ask before they give one number to a path.\n\n"
        "Raises ValueError where the path names a vector without an index.");
}

}  // namespace

void bind_compiled_scenario(nb::module_& m) {
  bind_channels(m);
  bind_state_value(m);
  nb::class_<LoadedScenario> c(m, "CompiledScenario",
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
  // Immutable: a copy is the object itself.
  c.def(
      "__copy__", [](nb::object self) { return self; },
      nb::sig("def __copy__(self) -> typing.Self"));
  c.def(
      "__deepcopy__", [](nb::object self, nb::handle) { return self; }, nb::arg("memo"),
      nb::sig("def __deepcopy__(self, memo: typing.Any) -> typing.Self"));
  bind_identity(c);
  bind_time_and_spaces(c);
  bind_sensors(c);
  bind_params(c);
}

}  // namespace skybody::python
