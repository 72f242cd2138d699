#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/direct_control.h"
#include "python/native/errors.h"
#include "python/native/simulation.h"

namespace skybody::python {
namespace {

using S = DirectSimulation;
using Class = nb::class_<S>;

/// A contact with the names of both partners.
struct NamedContact {
  Contact contact;
  std::string body, other;
};

void bind_contact(nb::module_& m) {
  nb::class_<NamedContact>(m, "Contact", "One place where a body touches something.")
      .def_ro("body", &NamedContact::body, "Which one, such as `quad.base_link`.")
      .def_ro("other", &NamedContact::other, "`ground`, `obstacle`, or the other body's name.")
      .def_prop_ro(
          "point", [](const NamedContact& c) { return vector3(c.contact.point); },
          nb::sig("def point(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: where the force acts, world axes [m].")
      .def_prop_ro(
          "normal", [](const NamedContact& c) { return vector3(c.contact.normal); },
          nb::sig("def normal(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: unit, world axes: the way in which `body` is pushed off.")
      .def_prop_ro(
          "depth", [](const NamedContact& c) { return c.contact.depth; }, "Penetration [m], >= 0.")
      .def_prop_ro(
          "force", [](const NamedContact& c) { return vector3(c.contact.force); },
          nb::sig("def force(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: on `body`, friction included, world axes [N].");
}

nb::object rows_of(const Accelerations& a, Vec3<double> BodyAcceleration::*part) {
  std::vector<double> values;
  for (const BodyAcceleration& body : a.bodies) {
    for (const double v : {(body.*part).x, (body.*part).y, (body.*part).z}) values.push_back(v);
  }
  return copy_of<double>(values, {a.bodies.size(), 3});
}

void bind_accelerations(nb::module_& m) {
  nb::class_<Accelerations>(m, "Accelerations", "How motion changes at one instant.")
      .def_prop_ro(
          "udot", [](const Accelerations& a) { return copy_of<double>(a.udot, {a.udot.size()}); },
          nb::sig("def udot(self) -> numpy.typing.NDArray[numpy.float64]"),
          "float64: of the generalised velocities, in the order of the world's joints.")
      .def_prop_ro(
          "linear", [](const Accelerations& a) { return rows_of(a, &BodyAcceleration::linear); },
          nb::sig("def linear(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(bodies, 3) float64: of each body's origin, world axes [m/s^2].")
      .def_prop_ro(
          "angular", [](const Accelerations& a) { return rows_of(a, &BodyAcceleration::angular); },
          nb::sig("def angular(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(bodies, 3) float64: of each body, in its own axes [rad/s^2].");
}

void bind_mass(nb::module_& m) {
  nb::class_<MassProperties>(m, "MassProperties", "Mass properties of one body, in its own frame.")
      .def_ro("mass", &MassProperties::mass, "[kg]")
      .def_prop_ro(
          "com", [](const MassProperties& p) { return vector3(p.com); },
          nb::sig("def com(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3,) float64: centre of mass [m].")
      .def_prop_ro(
          "inertia",
          [](const MassProperties& p) {
            const SymMat3<double>& i = p.inertia;
            const double rows[] = {i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz};
            return copy_of<double>(rows, {3, 3});
          },
          nb::sig("def inertia(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(3, 3) float64: about the centre of mass [kg m^2].");
}

void command(S& s, nb::handle values, const std::string& robot) {
  const int size = s.look([&](Simulation& sim) {
    return rethrow_as_argument_error([&] { return sim.command_size(robot); });
  });
  const auto row = read_array<double>(values, "command", {size});
  s.look(
      [&](Simulation& sim) { rethrow_as_argument_error([&] { sim.command(robot, row.span()); }); });
}

bool advance(S& s, std::int64_t steps) {
  return advance_in_pieces(steps, [&](std::int64_t piece) {
    return s.call([piece](Simulation& sim) { return sim.advance(piece); });
  });
}

void teleport(S& s, nb::handle position, nb::handle rotation, nb::handle velocity,
              nb::handle angular_velocity, const std::string& robot) {
  const NewMotion motion(position, rotation, velocity, angular_velocity);
  s.look([&](Simulation& sim) {
    rethrow_as_argument_error([&] { sim.teleport(robot, motion.applied_to(sim.base(robot))); });
  });
}

std::vector<NamedContact> contacts(S& s) {
  const std::vector<std::string> names = body_names(*s.compiled());
  std::vector<NamedContact> out;
  for (const Contact& c : s.call([](Simulation& sim) { return sim.contacts(); })) {
    const std::string other = c.other == kGround     ? "ground"
                              : is_obstacle(c.other) ? "obstacle"
                                                     : names[static_cast<std::size_t>(c.other)];
    out.push_back({c, names[static_cast<std::size_t>(c.body)], other});
  }
  return out;
}

void set_mass_properties(S& s, const std::string& link, nb::handle mass, nb::handle com,
                         nb::handle inertia, const std::string& robot) {
  MassProperties p = s.look([&](Simulation& sim) {
    return rethrow_as_argument_error([&] { return sim.mass_properties(robot, link); });
  });
  if (!mass.is_none()) p.mass = nb::cast<double>(mass);
  if (!com.is_none()) {
    const auto values = read_array<double>(com, "com", {3});
    p.com = {values.span()[0], values.span()[1], values.span()[2]};
  }
  if (!inertia.is_none()) {
    const auto values = read_array<double>(inertia, "inertia", {3, 3});
    const auto i = values.span();
    if (i[1] != i[3] || i[2] != i[6] || i[5] != i[7]) {
      throw nb::value_error("inertia is not symmetric: give (inertia + inertia.T) / 2");
    }
    p.inertia = {i[0], i[4], i[8], i[1], i[2], i[5]};
  }
  s.look([&](Simulation& sim) {
    rethrow_as_argument_error([&] { sim.set_mass_properties(robot, link, p); });
  });
}

void bind_commands(Class& c) {
  c.def(
      "command", &command, nb::arg("values").none(), nb::arg("robot") = "",
      nb::sig("def command(self, values: numpy.typing.NDArray[numpy.float64], robot: str = "
              "\"\") -> None"),
      "Sets the command of a robot's chains of controllers, in their signals' units. It is held "
      "until the\n"
      "next command, step or reset; a reset leaves zeros.\n\n"
      "values: (command_size,) float64; controllers hold it to what the robot can do\n"
      "robot: may be left out where there is one\n\n"
      "Raises TypeError on another dtype; ValueError on another shape, an unknown robot, a value\n"
      "that is not finite, or before reset().");
  c.def("command_size", of(&Simulation::command_size), nb::arg("robot") = "",
        "Number of values of a command.");
  c.def("advance", &advance, nb::arg("physics_steps") = 1,
        "Physics steps under the commands, sensors included; no action, no task. The GIL is\n"
        "released; KeyboardInterrupt gets through.\n\n"
        "Returns False if the physics gave up: the episode has then ended as a fault.\n"
        "Raises ValueError if physics_steps < 0, Error before reset().");
  c.def(
      "evaluate", [](S& s) { s.call([](Simulation& sim) { sim.evaluate(); }); },
      "Ends a transition made by command and advance, as step() ends its own: counts one step\n"
      "towards the horizon and asks the task for observation, reward and end.\n\n"
      "Raises Error before reset().");
  c.def(
      "teleport", &teleport, nb::arg("position") = nb::none(), nb::arg("rotation") = nb::none(),
      nb::arg("velocity") = nb::none(), nb::arg("angular_velocity") = nb::none(),
      nb::arg("robot") = "",
      nb::sig("def teleport(self, position: numpy.typing.NDArray[numpy.float64] | None = None, "
              "rotation: numpy.typing.NDArray[numpy.float64] | None = None, velocity: "
              "numpy.typing.NDArray[numpy.float64] | None = None, angular_velocity: "
              "numpy.typing.NDArray[numpy.float64] | None = None, robot: str = \"\") -> None"),
      "Puts a robot's floating base somewhere; what is left out, joints, rotors and other robots\n"
      "stay.\n\n"
      "position: (3,) world axes [m]; rotation: (4,) quaternion w x y z, world from body\n"
      "velocity: (3,) world axes [m/s]; angular_velocity: (3,) body axes [rad/s]; float64 all\n\n"
      "Raises ValueError on another shape, a fixed base, a value that is not finite, or before\n"
      "reset().");
}

void bind_looking(Class& c) {
  c.def_prop_ro(
      "body_names", [](const S& s) { return body_names(*s.compiled()); },
      "Names of all bodies, such as `quad.base_link`, in the world's numbering.");
  c.def_prop_ro(
      "goal_bodies", [](const S& s) { return goal_bodies(*s.compiled()); },
      "The body of each goal of the task, as in `body_names`.");
  c.def("base", of(&Simulation::base), nb::arg("robot") = "", "Motion of a robot's base.");
  c.def(
      "accelerations",
      [](S& s) { return s.call([](Simulation& sim) { return sim.accelerations(); }); },
      "Accelerations now: with the rotors' present speeds, and rotor commands and wrenches as the\n"
      "last physics step held them.");
  c.def("contacts", &contacts, "What touches the ground, obstacles or another robot now.");
}

void bind_constants(Class& c) {
  c.def(
      "mass_properties",
      [](S& s, const std::string& link, const std::string& robot) {
        return s.look([&](Simulation& sim) {
          return rethrow_as_argument_error([&] { return sim.mass_properties(robot, link); });
        });
      },
      nb::arg("link"), nb::arg("robot") = "",
      "Of the body that a link belongs to: links on fixed joints are one body.");
  c.def("set_mass_properties", &set_mass_properties, nb::arg("link"), nb::kw_only(),
        nb::arg("mass") = nb::none(), nb::arg("com") = nb::none(), nb::arg("inertia") = nb::none(),
        nb::arg("robot") = "",
        nb::sig("def set_mass_properties(self, link: str, *, mass: float | None = None, com: "
                "numpy.typing.NDArray[numpy.float64] | None = None, inertia: "
                "numpy.typing.NDArray[numpy.float64] | None = None, robot: str = \"\") -> None"),
        "Sets some of them, in mid-episode; controllers go on with the nominal ones.\n\n"
        "mass: [kg]; com: (3,) [m]; inertia: (3, 3), about the centre of mass [kg m^2]\n\n"
        "Raises ValueError if no rigid body can have them.");
  c.def(
      "rotor_parameter",
      [](S& s, int rotor, const std::string& name, const std::string& robot) {
        return s.look([&](Simulation& sim) {
          return rethrow_as_argument_error([&] { return sim.rotor_parameter(robot, rotor, name); });
        });
      },
      nb::arg("rotor"), nb::arg("name"), nb::arg("robot") = "",
      "A constant of one rotor (thrust_constant, max_speed, tau_up and so on), counted from 0 in\n"
      "the order of the rotors file; units as there.");
  c.def(
      "set_rotor_parameter",
      [](S& s, int rotor, const std::string& name, double value, const std::string& robot) {
        s.look([&](Simulation& sim) {
          rethrow_as_argument_error([&] { sim.set_rotor_parameter(robot, rotor, name, value); });
        });
      },
      nb::arg("rotor"), nb::arg("name"), nb::arg("value"), nb::arg("robot") = "",
      "Sets one.\n\nRaises ValueError if there is none, or outside its bounds.");
}

}  // namespace

void bind_direct_control(nb::module_& m, nb::class_<DirectSimulation>& c) {
  bind_contact(m);
  bind_accelerations(m);
  bind_mass(m);
  bind_commands(c);
  bind_looking(c);
  bind_constants(c);
}

}  // namespace skybody::python
