#include "core/io/yaml/scenario_fields.h"

#include <algorithm>
#include <utility>

#include "core/io/yaml/parameter_reader.h"
#include "core/io/yaml/ranges.h"

namespace skybody {
namespace {

constexpr double kMostObservedValue = 1e30;  // well inside the range of a float

Field hover_or(Field field) {
  field.word = "hover";
  return field;
}

/// The key of a row within its map.
std::string own_key(const ConstantRow& row) {
  const std::string key = row.key;
  return key.substr(key.rfind('.') + 1);
}

Field constant_field(const ConstantRow& row) {
  Field field =
      row.count == 1
          ? real_field(own_key(row), row.unit, row.fallback[0], row.least, row.greatest, row.doc)
          : vector_field(own_key(row), row.unit, {row.fallback, row.fallback + row.count},
                         row.least, row.greatest, row.doc);
  return row.is_required ? required(std::move(field)) : field;
}

/// Appends the fields of all constants whose keys begin with `prefix`.
std::vector<Field> with_constants(std::vector<Field> fields, std::span<const ConstantRow> rows,
                                  const std::string& prefix = "") {
  for (const ConstantRow& row : rows) {
    if (prefix + own_key(row) == row.key) fields.push_back(constant_field(row));
  }
  return fields;
}

/// A list of one or more numbers.
Field any_count(Field field) {
  field.value.max_count = -1;
  field.value.default_numbers.clear();
  return field;
}

Field may_be_empty(Field field) {
  field.value.min_count = 0;
  return field;
}

Field no_default(Field field) {
  field.value.default_numbers.clear();
  return field;
}

}  // namespace

void read_constants(const MapReader& reader, std::span<const ConstantRow> rows, double* values) {
  for (const ConstantRow& row : rows) {
    const std::string key = own_key(row);
    if (!reader.knows(key)) continue;
    const std::vector<double> numbers = reader.numbers(key);
    std::copy(numbers.begin(), numbers.end(), values + row.place);
  }
}

const MapSpec& solver_fields() {
  static const MapSpec spec{
      "solver",
      "Settings of the integrators `cvode` and `arkode`. They restart at every physics step.",
      {
          choice_field("method", {"auto", "adams", "bdf", "erk", "dirk"},
                       "cvode: adams or bdf (stiff); arkode: erk (explicit) or dirk (stiff), both "
                       "of order 4; auto: adams and erk"),
          real_field("relative_tolerance", "", 1e-8, 1e-14, 0.1,
                     "largest error of an internal step, relative to the value"),
          real_field("absolute_tolerance", "m, rad, m/s, rad/s", 1e-11, 1e-15, 0.1,
                     "largest absolute error of an internal step, added to the relative one"),
          integer_field("max_steps", 500, 1, 1e6,
                        "largest number of internal steps in one physics step; more are a fault"),
      }};
  return spec;
}

const MapSpec& stepping_fields() {
  static const MapSpec spec{
      "stepping",
      "The time grid, and the integration of the motion.",
      {
          real_field("dt", "s", 0.001, 1e-6, 0.1, "physics step"),
          integer_field("action_repeat", 1, 1, 100000, "K, physics steps per action"),
          integer_field("horizon", 0, 0, 2e9, "actions until an episode is truncated; 0: never"),
          choice_field(
              "dynamics", {"auto", "simbody", "tree"},
              "algorithm for accelerations; tree: Skybody's own, in vector lanes; auto: tree"),
          choice_field("integrator", {kIntegratorNames.begin(), kIntegratorNames.end()},
                       "integration method; midpoint: second order; semi_implicit_euler: first "
                       "order, the cheapest; rk4: fourth order; cvode, arkode: SUNDIALS, with "
                       "error control, only for stiff systems: they restart at every physics step, "
                       "so for other systems they are slow and no more exact than rk4"),
          map_field("solver", Field::Kind::kMap, solver_fields(),
                    "settings of cvode and arkode; null: the same as omitted"),
      }};
  return spec;
}

const MapSpec& contact_fields() {
  static const MapSpec spec{
      "contact", "Contact of robots with the ground, obstacles and each other (docs/contact.md).",
      with_constants(
          {
              boolean_field("ground", true, "whether robots collide with the ground"),
              real_field("penetration", "m", 0.001, 1e-6, 1.0,
                         "depth to which a robot at rest sinks into the ground under its own "
                         "weight; determines the stiffness"),
              integer_field("redraws", 16, 0, 1000,
                            "largest number of repeated draws of a start in which a robot begins "
                            "inside something; an overlap after the last one is a fault; 0: starts "
                            "are kept as drawn"),
          },
          kWorldConstants, "contact.")};
  return spec;
}

const MapSpec& pose_fields() {
  static const MapSpec spec{
      "pose",
      "A pose in the world.",
      {
          vector_field("position", "m", {0, 0, 0}, -kFar, kFar, "origin in W"),
          vector_field("rpy", "rad", {0, 0, 0}, -kMostTurned, kMostTurned,
                       "roll, pitch, yaw about the fixed axes x, y, z of W, in this order"),
      }};
  return spec;
}

const MapSpec& disturbance_fields() {
  static const MapSpec spec{"disturbance", "A constant load on the base.",
                            with_constants({}, kRobotConstants, "disturbance.")};
  return spec;
}

const MapSpec& joint_fields() {
  static const MapSpec spec{
      "joint",
      "Values that replace or complete those of one joint of the URDF. Omitted keys keep the "
      "URDF's values.",
      with_constants({real_field("position", "rad or m", 0, -kFar, kFar,
                                 "position at a reset; revolute and prismatic joints")},
                     kJointConstants)};
  return spec;
}

const MapSpec& robot_fields() {
  static const MapSpec spec{
      "robot",
      "One robot.",
      {
          required(name_field("its name in paths")),
          required(text_field("model", "", "URDF file, relative to the file that names it")),
          text_field("rotors", "",
                     "rotors file, or `none`; default: rotors.yaml beside the URDF, if it exists"),
          boolean_field("fixed_base", false, "weld the base to the world"),
          choice_field("inertia", {"as_written", "repair"},
                       "repair: an inertia of the URDF that is not physical for a rigid body is "
                       "replaced by a near one that is, with a warning instead of an error"),
          map_field("pose", Field::Kind::kMap, pose_fields(), "pose of the base at a reset"),
          hover_or(real_field("rotor_speed", "rad/s", 0.0, 0.0, kFar,
                              "speed of every rotor at a reset; hover: the speed at which the "
                              "rotors carry the robot's nominal weight")),
          map_field("disturbance", Field::Kind::kMap, disturbance_fields(),
                    "a constant load on the base"),
          map_field("joints", Field::Kind::kNamedMaps, joint_fields(),
                    "positions at a reset, springs and dampers by joint name"),
          plugin_field("controllers", Field::Kind::kPluginList, SKYBODY_CONTROLLER,
                       "in order of evaluation"),
      }};
  return spec;
}

const MapSpec& team_fields() {
  static const MapSpec spec{
      "team",
      "Robots with common controllers.",
      {
          required(name_field("its name in paths")),
          required(list_field(
              "robots", "names of robots, in the order in which the controllers receive them")),
          required(plugin_field("controllers", Field::Kind::kPluginList, SKYBODY_CONTROLLER,
                                "in order of evaluation; the outputs of the last one are inputs of "
                                "the robots' own controllers, or of actuators")),
      }};
  return spec;
}

const MapSpec& height_field_fields() {
  static const MapSpec spec{
      "height_field",
      "Heights on a grid of rectangular cells, each of two triangles; solid below them.",
      {
          required(vector_field("size", "m", {1, 1}, kSmallestLength, kFar, "along x and y")),
          text_field("file", "",
                     "a .csv file: one line per row, in order of increasing y; heights [m] in "
                     "order of increasing x"),
          any_count(real_field("heights", "m", 0, -kFar, kFar,
                               "instead of a file: all heights, row by row")),
          integer_field("columns", 2, 2, 1e6, "number of heights in each row of `heights`"),
      }};
  return spec;
}

const MapSpec& obstacle_fields() {
  static const MapSpec spec{
      "obstacle",
      "A fixed shape in the world: one of box, sphere, cylinder, capsule, gate, plane, "
      "height_field.",
      {
          required(name_field("its name")),
          vector_field("box", "m", {1, 1, 1}, kSmallestLength, kFar, "edge lengths"),
          real_field("sphere", "m", 1, kSmallestLength, kFar, "radius"),
          vector_field("cylinder", "m", {1, 1}, kSmallestLength, kFar, "radius, length along z"),
          vector_field("capsule", "m", {1, 1}, kSmallestLength, kFar,
                       "radius, length along z between the centres of its caps"),
          vector_field("gate", "m", {1, 1, 0.1}, kSmallestLength, kFar,
                       "a frame of four bars: width (y) and height (z) of the opening, thickness "
                       "of the bars; the passage is along x"),
          boolean_field("plane", false, "true: the unbounded solid below z = 0 of its frame"),
          map_field("height_field", Field::Kind::kMap, height_field_fields(),
                    "uneven ground: solid below a grid of heights, relative to z = 0 of its frame"),
          vector_field("position", "m", {0, 0, 0}, -kFar, kFar, "position of its centre in W"),
          vector_field("rpy", "rad", {0, 0, 0}, -kMostTurned, kMostTurned,
                       "roll, pitch, yaw about the fixed axes of W"),
      }};
  return spec;
}

const MapSpec& coupling_end_fields() {
  static const MapSpec spec{
      "end",
      "One end of a coupling: a point of a robot's link, or of the world.",
      {
          text_field("robot", "", "name of the robot; default: the world"),
          text_field("link", "", "link of the robot; default: the base"),
          vector_field("point", "m", {0, 0, 0}, -kFar, kFar, "in the link's frame, or in W"),
      }};
  return spec;
}

const MapSpec& coupling_fields() {
  const auto row = [](CouplingParam place) {
    return constant_field(row_at(kCouplingConstants, place));
  };
  Field length = row(kCouplingLength);
  length.value.required = false;
  length.value.doc += "; default: the distance at the start";
  static const MapSpec spec{
      "coupling",
      "A connection between two bodies, or between a body and the world (docs/couplings.md).",
      {
          required(name_field("its name in paths")),
          required(
              choice_field("kind", {kCouplingNames.begin(), kCouplingNames.end()},
                           "rod: keeps its ends at a fixed distance; rope: limits their distance; "
                           "point: keeps them at the same place; spring: a spring and a "
                           "damper along the line between them")),
          required(map_field("ends", Field::Kind::kMapList, coupling_end_fields(), "the two ends")),
          length,
          row(kCouplingStiffness),
          row(kCouplingDamping),
          row(kCouplingPresent),
      }};
  return spec;
}

const MapSpec& observed_fields() {
  static const MapSpec spec{
      "observed",
      "A sensor channel added to the observation, or a task's column for the critic alone.",
      {
          required(text_field("channel", "",
                              "the sensor and its channel: SENSOR.CHANNEL; or task.COLUMN")),
          name_field("name of the column; default: SENSOR.CHANNEL, or COLUMN"),
          boolean_field("privileged", false, "for a critic only: not in the policy's observation"),
          no_default(real_field(
              "low", "", 0, -kMostObservedValue, kMostObservedValue,
              "least value of the space, in the channel's unit; default: declared by the sensor")),
          no_default(real_field("high", "", 0, -kMostObservedValue, kMostObservedValue,
                                "greatest value, likewise")),
      }};
  return spec;
}

const MapSpec& plugin_use_fields() {
  static const MapSpec parameters{
      "parameters", "Parameters of the plugin, as it declares them.", {}};
  static const MapSpec spec{
      "plugin",
      "One use of a plugin.",
      {
          required(text_field("plugin", "", "the plugin's name, see `skybody plugins`")),
          name_field("its name in paths; default: the plugin's name"),
          map_field("parameters", Field::Kind::kMap, parameters,
                    "values of parameters that the plugin declares"),
      }};
  return spec;
}

const MapSpec& scenario_fields() {
  static const MapSpec spec{
      "scenario",
      "The parts of one environment.",
      {
          name_field("name for tables and logs; default: the file's name"),
          map_field("stepping", Field::Kind::kMap, stepping_fields(),
                    "the time grid, and the integration of the motion"),
          constant_field(row_at(kWorldConstants, kGravity)),
          map_field("contact", Field::Kind::kMap, contact_fields(),
                    "contact of robots with the ground, obstacles and each other"),
          required(
              map_field("robots", Field::Kind::kMapList, robot_fields(), "at least one robot")),
          map_field("teams", Field::Kind::kMapList, team_fields(),
                    "groups of robots with common controllers"),
          map_field("obstacles", Field::Kind::kMapList, obstacle_fields(), "fixed shapes"),
          map_field("couplings", Field::Kind::kMapList, coupling_fields(),
                    "connections between bodies, or between bodies and the world"),
          plugin_field("sensors", Field::Kind::kPluginList, SKYBODY_SENSOR,
                       "sensors, in order of evaluation"),
          plugin_field("effects", Field::Kind::kPluginList, SKYBODY_EFFECT,
                       "effects on bodies and rotors in addition to the controllers, in order of "
                       "evaluation"),
          short_form(
              "channel",
              map_field("observe", Field::Kind::kMapList, observed_fields(),
                        "sensor channels that are added to the task's observation, in order")),
          may_be_empty(list_field(
              "infos", "paths of randomizable values that are added to the infos, unchanged")),
          plugin_field("randomization", Field::Kind::kPluginList, SKYBODY_RANDOMIZER,
                       "randomizers, which draw values at a reset, in order of evaluation"),
          required(plugin_field("task", Field::Kind::kPlugin, SKYBODY_TASK,
                                "observation, reward and end of an episode")),
      }};
  return spec;
}

const MapSpec& rotor_fields() {
  static const MapSpec spec{
      "rotor", "One rotor; `defaults` has the same keys.",
      with_constants(
          {
              required(name_field("its name in paths")),
              text_field("link", "", "link that carries the rotor; default: the base"),
              vector_field("axis", "", {0, 0, 1}, -kFar, kFar,
                           "thrust direction in the link's frame, of any length except 0"),
              required(
                  choice_field("direction", {"ccw", "cw"}, "sense of rotation about the axis")),
              real_field("min_speed", "rad/s", 0.0, -1e5, 0.0,
                         "below 0: the rotor may turn backwards up to this speed, and then pushes "
                         "against its axis with the same constants"),
          },
          kRotorConstants)};
  return spec;
}

const MapSpec& rotors_file_fields() {
  static const MapSpec spec{
      "rotors file",
      "The rotors of one model.",
      {
          text_field("source", "", "source of the constants"),
          map_field("defaults", Field::Kind::kMap, rotor_fields(), "merged into every rotor"),
          required(
              map_field("rotors", Field::Kind::kMapList, rotor_fields(), "at least one rotor")),
      }};
  return spec;
}

std::string too_many_entries(const std::string& key, std::size_t count, std::size_t most) {
  return "`" + key + "` has " + std::to_string(count) + " entries; allowed: at most " +
         std::to_string(most);
}

std::string scenario_reference() {
  const MapSpec* specs[] = {&scenario_fields(),     &stepping_fields(),     &solver_fields(),
                            &contact_fields(),      &robot_fields(),        &pose_fields(),
                            &disturbance_fields(),  &joint_fields(),        &team_fields(),
                            &obstacle_fields(),     &height_field_fields(), &coupling_fields(),
                            &coupling_end_fields(), &observed_fields(),     &plugin_use_fields(),
                            &rotors_file_fields(),  &rotor_fields()};
  std::string text;
  for (const MapSpec* spec : specs) {
    text += "## " + spec->name + "\n\n" + spec->doc + "\n\n";
    text +=
        "| key | allowed | default | meaning |\n"
        "|---|---|---|---|\n";
    for (const Field& field : spec->fields) {
      std::string allowed = describe_allowed(field.value);
      if (field.kind == Field::Kind::kMap) allowed = "a map: " + field.map->name;
      if (field.kind == Field::Kind::kMapList) allowed = "a list of maps: " + field.map->name;
      if (!field.short_key.empty()) allowed += ", or their `" + field.short_key + "` alone";
      if (field.kind == Field::Kind::kNamedMaps) allowed = "maps by name: " + field.map->name;
      if (field.kind == Field::Kind::kPlugin) allowed = "a plugin use";
      if (field.kind == Field::Kind::kPluginList) allowed = "a list of plugin uses";
      if (!field.word.empty()) allowed += ", or `" + field.word + "`";
      text += "| `" + field.value.name + "` | " + allowed + " | " + default_text(field.value) +
              " | " + field.value.doc + " |\n";
    }
    text += '\n';
  }
  return text;
}

}  // namespace skybody
