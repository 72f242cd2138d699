// Collision shapes of a scenario, as returned to plugins by Setup::shapes().
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/env/plugin_setup_tables.h"
#include "python/native/bindings.h"
#include "python/native/shapes.h"

namespace skybody::python {
namespace {

/// A kind of shape: its name in files, and the number of its size values.
struct Kind {
  const char* word;
  int size;
};
constexpr Kind kKinds[] = {{"box", 3},  {"cylinder", 2}, {"sphere", 1}, {"mesh", 3},
                           {"gate", 3}, {"capsule", 2},  {"plane", 0},  {"height_field", 3}};
static_assert(std::size(kKinds) == SKYBODY_HEIGHT_FIELD + 1, "a row for each kind of abi.h");

Kind kind_of(const SkybodyShapeInfo& info) {
  const bool is_known = info.kind >= 0 && info.kind < static_cast<int>(std::size(kKinds));
  return is_known ? kKinds[info.kind] : Kind{"", 3};
}

std::string in_numbers(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    char one[32];
    std::snprintf(one, sizeof one, "%s%.4g", text.empty() ? "" : ", ", number);
    text += one;
  }
  return text;
}

}  // namespace

std::vector<NamedShape> shapes_of(const CompiledScenario& compiled) {
  const SetupTables tables(compiled.world(), compiled.layout());
  std::vector<NamedShape> shapes;
  for (const SkybodyShapeInfo& info : tables.shapes()) {
    NamedShape shape;
    shape.id = static_cast<int>(shapes.size());
    shape.name = info.name;
    shape.mesh = info.mesh;
    shape.kind = kind_of(info).word;
    shape.size.assign(info.size, info.size + kind_of(info).size);
    std::copy_n(info.position, 3, shape.position.begin());
    std::copy_n(info.rotation, 4, shape.rotation.begin());
    shape.body = info.body;
    shape.obstacle = info.obstacle;
    shape.first_param = info.first_param;
    if (info.robot >= 0) {
      shape.robot = compiled.scenario().robots[static_cast<std::size_t>(info.robot)].name;
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

std::vector<NamedShape> obstacles_of(const CompiledScenario& compiled) {
  std::vector<NamedShape> obstacles;
  for (NamedShape& shape : shapes_of(compiled)) {
    if (shape.obstacle >= 0) obstacles.push_back(std::move(shape));
  }
  return obstacles;
}

void bind_shapes(nb::module_& m) {
  using S = NamedShape;
  nb::class_<S>(m, "Shape",
                "A collision shape of a body, or an obstacle, as the scenario has it. Where an "
                "obstacle is in an environment, how large, and whether, are parameters: "
                "`obstacles.NAME.position[0]`, `.rotation[0]`, `.size[0]`, `.present`.")
      .def_ro("id", &S::id, "Its place among all shapes: the same in a plugin's Setup::shapes().")
      .def_ro("name", &S::name, "Name of the obstacle, or of the body.")
      .def_ro("kind", &S::kind, "`box`, `cylinder`, `sphere`, `mesh`, or of obstacles `gate`.")
      .def_prop_ro(
          "size", [](const S& s) { return nb::tuple(nb::cast(s.size)); },
          nb::sig("def size(self) -> tuple[float, ...]"),
          "Box: edge lengths; cylinder: radius, length along z; sphere: radius; gate: width (y) "
          "and height (z) of the opening, thickness [m]. Mesh: scale factors.")
      .def_prop_ro(
          "position",
          [](const S& s) { return std::make_tuple(s.position[0], s.position[1], s.position[2]); },
          "Of its centre in the body's frame; of an obstacle in W [m].")
      .def_prop_ro(
          "rotation",
          [](const S& s) {
            return std::make_tuple(s.rotation[0], s.rotation[1], s.rotation[2], s.rotation[3]);
          },
          "Quaternion w x y z: the body's frame (W) from the shape's.")
      .def_ro("robot", &S::robot, "Name of its robot; None: an obstacle.")
      .def_ro("body", &S::body, "Index of its body among all bodies; -1: an obstacle.")
      .def_ro("obstacle", &S::obstacle, "Its place among the obstacles; -1: of a body.")
      .def_ro("first_param", &S::first_param,
              "Index in `param_paths` of an obstacle's `present`, which its pose and its size "
              "follow; -1: of a body, whose shapes do not change.")
      .def_ro("mesh", &S::mesh, "File of a mesh, else empty.")
      .def("__repr__", [](const S& s) {
        return "Shape(" + s.name + ": " + s.kind + " [" + in_numbers(s.size) + "])";
      });
}

}  // namespace skybody::python
