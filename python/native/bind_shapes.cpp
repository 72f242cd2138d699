// Parts of a scenario's world: shapes, rotors, couplings.
#include <nanobind/stl/array.h>
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

#include "core/base/system/error.h"
#include "core/env/plugin_setup_tables.h"
#include "python/native/arrays.h"
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

NamedShape named(const CompiledScenario& compiled, const SkybodyShapeInfo& info, int id) {
  NamedShape shape;
  shape.id = id;
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
  return shape;
}

/// @throws Error if they could not be read
std::vector<float> corners_of(const SkybodyTriangles& triangles, const std::string& name) {
  if (*triangles.problem != '\0') throw Error(name + ": " + triangles.problem);
  return {triangles.corners, triangles.corners + 9 * static_cast<std::ptrdiff_t>(triangles.count)};
}

}  // namespace

std::vector<NamedShape> shapes_of(const CompiledScenario& compiled) {
  const SetupTables tables(compiled.world(), compiled.layout());
  std::vector<NamedShape> shapes;
  for (const SkybodyShapeInfo& info : tables.shapes()) {
    shapes.push_back(named(compiled, info, static_cast<int>(shapes.size())));
  }
  return shapes;
}

std::vector<Visual> visuals_of(const CompiledScenario& compiled) {
  const SetupTables tables(compiled.world(), compiled.layout());
  const SkybodySetup setup = tables.setup("python", {}, {});
  std::vector<Visual> visuals;
  for (const SkybodyVisualInfo& info : tables.visuals()) {
    const int index = static_cast<int>(visuals.size());
    Visual visual{named(compiled, info.shape, index), {}, {}};
    std::copy_n(info.color, 4, visual.color.begin());
    if (info.shape.kind == SKYBODY_MESH) {
      visual.corners = corners_of(*setup.visual_triangles(setup.tables, index), visual.mesh);
    }
    visuals.push_back(std::move(visual));
  }
  return visuals;
}

std::vector<float> field_corners(const CompiledScenario& compiled, int obstacle) {
  const SetupTables tables(compiled.world(), compiled.layout());
  const SkybodySetup setup = tables.setup("python", {}, {});
  return corners_of(*setup.obstacle_triangles(setup.tables, obstacle), "the height field");
}

std::vector<NamedShape> obstacles_of(const CompiledScenario& compiled) {
  std::vector<NamedShape> obstacles;
  for (NamedShape& shape : shapes_of(compiled)) {
    if (shape.obstacle >= 0) obstacles.push_back(std::move(shape));
  }
  return obstacles;
}

std::vector<PlacedRotor> rotors_of(const CompiledScenario& compiled) {
  const SetupTables tables(compiled.world(), compiled.layout());
  std::vector<PlacedRotor> rotors;
  for (const SkybodyRotorInfo& info : tables.rotors()) {
    PlacedRotor rotor;
    rotor.name =
        compiled.scenario().robots[static_cast<std::size_t>(info.robot)].name + "." + info.name;
    rotor.body = info.body;
    std::copy_n(info.position, 3, rotor.position.begin());
    std::copy_n(info.axis, 3, rotor.axis.begin());
    rotor.direction = info.direction;
    rotor.thrust_constant = info.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
    rotors.push_back(std::move(rotor));
  }
  return rotors;
}

std::vector<NamedCoupling> couplings_of(const CompiledScenario& compiled) {
  static constexpr const char* kWords[] = {"rod", "rope", "point", "spring"};
  std::vector<int> first_body;
  int next = 0;
  for (const RobotUse& robot : compiled.scenario().robots) {
    first_body.push_back(next);
    next += static_cast<int>(robot.model.bodies.size());
  }
  std::vector<NamedCoupling> couplings;
  for (const Coupling& coupling : compiled.scenario().couplings) {
    NamedCoupling named{coupling.name, kWords[static_cast<int>(coupling.kind)], {}, {}};
    for (std::size_t k = 0; k < 2; ++k) {
      const CouplingEnd& end = coupling.ends[k];
      named.bodies[k] =
          end.robot < 0 ? -1 : first_body[static_cast<std::size_t>(end.robot)] + end.body;
      named.points[k] = {end.point.x, end.point.y, end.point.z};
    }
    couplings.push_back(std::move(named));
  }
  return couplings;
}

void bind_rotors_and_couplings(nb::module_& m) {
  using R = PlacedRotor;
  nb::class_<R>(m, "Rotor", "A rotor at its place on a body.")
      .def_ro("name", &R::name, "ROBOT.ROTOR.")
      .def_ro("body", &R::body, "Index of its body among all bodies.")
      .def_ro("position", &R::position, "Of its hub in the body's frame [m].")
      .def_ro("axis", &R::axis, "Unit vector of its thrust, body frame.")
      .def_ro("direction", &R::direction, "+1 counter-clockwise about the axis, -1 clockwise.")
      .def_ro("thrust_constant", &R::thrust_constant,
              "Nominal thrust over the squared speed [N s^2/rad^2].")
      .def("__repr__", [](const R& r) { return "Rotor(" + r.name + ")"; });
  using C = NamedCoupling;
  nb::class_<C>(m, "Coupling", "A coupling of two bodies, or of a body and the world.")
      .def_ro("name", &C::name, "Its name.")
      .def_ro("kind", &C::kind, "`rod`, `rope`, `point` or `spring`.")
      .def_ro("bodies", &C::bodies, "Indices of the two bodies among all; -1: the world.")
      .def_ro("points", &C::points, "The ends, each in its body's frame or in W [m].")
      .def("__repr__", [](const C& c) { return "Coupling(" + c.name + ": " + c.kind + ")"; });
}

void bind_shapes(nb::module_& m) {
  bind_rotors_and_couplings(m);
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
  nb::class_<Visual, S>(m, "Visual", "A shape of a body that is drawn.")
      .def_prop_ro(
          "color",
          [](const Visual& v) {
            return std::make_tuple(v.color[0], v.color[1], v.color[2], v.color[3]);
          },
          "Red, green, blue and opacity, each in [0, 1].")
      .def_prop_ro(
          "corners",
          [](const Visual& v) {
            return copy_of<float>(v.corners, {v.corners.size() / 9, 3, 3});
          },
          nb::sig("def corners(self) -> numpy.ndarray"),
          "Corners of a mesh's triangles, unscaled [m]: (triangles, 3, 3) float32.");
}

}  // namespace skybody::python
