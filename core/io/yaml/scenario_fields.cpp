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
      "How the integrators `cvode` and `arkode` work. They start anew at every physics step.",
      {
          choice_field("method", {"auto", "adams", "bdf", "erk", "dirk"},
                       "cvode: adams or bdf (stiff); arkode: erk (explicit) or dirk (stiff), both "
                       "of order 4; auto: adams and erk"),
          real_field("relative_tolerance", "", 1e-8, 1e-14, 0.1,
                     "largest error of one of its steps, by the size of the value"),
          real_field("absolute_tolerance", "m, rad, m/s, rad/s", 1e-11, 1e-15, 0.1,
                     "what is added to that"),
          integer_field("max_steps", 500, 1, 1e6,
                        "most steps of its own in one physics step; more are a fault"),
      }};
  return spec;
}

const MapSpec& stepping_fields() {
  static const MapSpec spec{
      "stepping",
      "The time grid and how it is advanced.",
      {
          real_field("dt", "s", 0.001, 1e-6, 0.1, "physics step"),
          integer_field("action_repeat", 1, 1, 100000, "K, physics steps an action"),
          integer_field("horizon", 0, 0, 2e9, "actions until an episode is truncated; 0: never"),
          choice_field(
              "dynamics", {"auto", "simbody", "tree"},
              "what computes accelerations; tree: our own algorithms, in vector lanes; auto: tree"),
          choice_field("integrator", {kIntegratorNames.begin(), kIntegratorNames.end()},
                       "what advances the state; midpoint: of second order, semi_implicit_euler: "
                       "of first, the cheapest; rk4: of fourth; cvode, arkode: SUNDIALS, with "
                       "control of its error, for stiff systems alone: it starts anew at every "
                       "physics step, slow and no more exact than rk4 elsewhere"),
          map_field("solver", Field::Kind::kMap, solver_fields(),
                    "how cvode and arkode work; null: as if left out"),
      }};
  return spec;
}

const MapSpec& contact_fields() {
  static const MapSpec spec{
      "contact", "Contact of robots with the ground, obstacles and each other (docs/contact.md).",
      with_constants(
          {
              boolean_field("ground", true, "whether the ground carries robots"),
              real_field(
                  "penetration", "m", 0.001, 1e-6, 1.0,
                  "how deep a robot stands in the ground by its own weight; fixes the stiffness"),
              integer_field("redraws", 16, 0, 1000,
                            "how often randomizers draw a start again in which a robot begins "
                            "inside something; still so then: a fault; 0: starts are taken as "
                            "drawn"),
          },
          kWorldConstants, "contact.")};
  return spec;
}

const MapSpec& pose_fields() {
  static const MapSpec spec{
      "pose",
      "A place in the world.",
      {
          vector_field("position", "m", {0, 0, 0}, -kFar, kFar, "origin in W"),
          vector_field("rpy", "rad", {0, 0, 0}, -kMostTurned, kMostTurned,
                       "roll, pitch, yaw about the fixed axes x, y, z of W, in this order"),
      }};
  return spec;
}

const MapSpec& disturbance_fields() {
  static const MapSpec spec{"disturbance", "A steady load on the base.",
                            with_constants({}, kRobotConstants, "disturbance.")};
  return spec;
}

const MapSpec& joint_fields() {
  static const MapSpec spec{
      "joint", "What replaces or completes the URDF's values of one joint; what is left out stays.",
      with_constants({real_field("position", "rad or m", 0, -kFar, kFar,
                                 "at a reset; revolute and prismatic joints")},
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
                     "rotors file, or `none`; without this key it is rotors.yaml beside the URDF, "
                     "where that exists"),
          boolean_field("fixed_base", false, "weld the base to the world"),
          choice_field("inertia", {"as_written", "repair"},
                       "repair: inertias in the URDF that no rigid body has become near ones, with "
                       "a warning, in place of an error"),
          map_field("pose", Field::Kind::kMap, pose_fields(), "of the base at reset"),
          hover_or(real_field(
              "rotor_speed", "rad/s", 0.0, 0.0, kFar,
              "of every rotor at reset; hover: what carries the robot's nominal weight")),
          map_field("disturbance", Field::Kind::kMap, disturbance_fields(),
                    "a steady load on the base"),
          map_field("joints", Field::Kind::kNamedMaps, joint_fields(),
                    "positions at a reset, springs and dampers by joint name"),
          plugin_field("controllers", Field::Kind::kPluginList, SKYBODY_CONTROLLER,
                       "in the order in which they are evaluated"),
      }};
  return spec;
}

const MapSpec& team_fields() {
  static const MapSpec spec{
      "team",
      "Robots that controllers serve together.",
      {
          required(name_field("its name in paths")),
          required(list_field("robots", "names of robots, in the order that controllers see")),
          required(plugin_field("controllers", Field::Kind::kPluginList, SKYBODY_CONTROLLER,
                                "in the order in which they are evaluated; what the last one gives "
                                "goes to robots' own controllers, or to actuators")),
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
                     "a .csv file: a line for each row in the order of rising y, with numbers in "
                     "the order of rising x [m]"),
          any_count(real_field("heights", "m", 0, -kFar, kFar,
                               "in place of a file: all heights, row after row")),
          integer_field("columns", 2, 2, 1e6, "of `heights`: how many a row has"),
      }};
  return spec;
}

const MapSpec& obstacle_fields() {
  static const MapSpec spec{
      "obstacle",
      "A shape that stands in the world: one of box, sphere, cylinder, capsule, gate, plane, "
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
                       "of the bars; its way through is x"),
          boolean_field("plane", false, "true: all below z = 0 of its frame, without end"),
          map_field("height_field", Field::Kind::kMap, height_field_fields(),
                    "ground with hills: all below a grid of heights above z = 0 of its frame"),
          vector_field("position", "m", {0, 0, 0}, -kFar, kFar, "of its centre in W"),
          vector_field("rpy", "rad", {0, 0, 0}, -kMostTurned, kMostTurned,
                       "roll, pitch, yaw about the fixed axes of W"),
      }};
  return spec;
}

const MapSpec& coupling_end_fields() {
  static const MapSpec spec{
      "end",
      "What a coupling holds on to: a point of a robot's link, or of the world.",
      {
          text_field("robot", "", "its name; without this key: the world"),
          text_field("link", "", "of the robot; default: the base"),
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
  length.value.doc += "; without this key what the start has";
  static const MapSpec spec{
      "coupling",
      "What joins two bodies, or a body and the world (docs/couplings.md).",
      {
          required(name_field("its name in paths")),
          required(choice_field("kind", {kCouplingNames.begin(), kCouplingNames.end()},
                                "rod: keeps its ends at a distance; rope: lets them get no farther "
                                "apart; point: keeps them at one place; spring: a spring and a "
                                "damper along the line between them")),
          required(map_field("ends", Field::Kind::kMapList, coupling_end_fields(), "two of them")),
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
      "A sensor's channel that joins the task's observation.",
      {
          required(text_field("channel", "", "the sensor and its channel: SENSOR.CHANNEL")),
          name_field("of the column; default: SENSOR.CHANNEL"),
          boolean_field("privileged", false, "for a critic only: not in the policy's observation"),
          no_default(real_field("low", "", 0, -kMostObservedValue, kMostObservedValue,
                                "least value of the space, in the channel's unit; else as the "
                                "sensor declares")),
          no_default(real_field("high", "", 0, -kMostObservedValue, kMostObservedValue,
                                "greatest value, likewise")),
      }};
  return spec;
}

const MapSpec& plugin_use_fields() {
  static const MapSpec parameters{"parameters", "As the plugin declares them.", {}};
  static const MapSpec spec{
      "plugin",
      "One use of a plugin.",
      {
          required(text_field("plugin", "", "the plugin's name, see `skybody plugins`")),
          name_field("its name in paths; default: the plugin's name"),
          map_field("parameters", Field::Kind::kMap, parameters, "as the plugin declares them"),
      }};
  return spec;
}

const MapSpec& scenario_fields() {
  static const MapSpec spec{
      "scenario",
      "The parts of one environment.",
      {
          name_field("for tables and logs; default: the file's name"),
          map_field("stepping", Field::Kind::kMap, stepping_fields(),
                    "the time grid and how it is advanced"),
          constant_field(row_at(kWorldConstants, kGravity)),
          map_field("contact", Field::Kind::kMap, contact_fields(), "how things touch"),
          required(
              map_field("robots", Field::Kind::kMapList, robot_fields(), "at least one robot")),
          map_field("teams", Field::Kind::kMapList, team_fields(),
                    "robots that controllers serve together"),
          map_field("obstacles", Field::Kind::kMapList, obstacle_fields(),
                    "shapes that stand still"),
          map_field("couplings", Field::Kind::kMapList, coupling_fields(),
                    "what joins robots, bodies and the world"),
          plugin_field("sensors", Field::Kind::kPluginList, SKYBODY_SENSOR,
                       "what measures, in the order of evaluation"),
          plugin_field("effects", Field::Kind::kPluginList, SKYBODY_EFFECT,
                       "what acts on bodies and rotors beside the controllers, in order"),
          short_form("channel", map_field("observe", Field::Kind::kMapList, observed_fields(),
                                          "channels of sensors that join the task's observation, "
                                          "in order")),
          may_be_empty(
              list_field("infos", "paths of randomizable values that join the infos, as they are")),
          plugin_field("randomization", Field::Kind::kPluginList, SKYBODY_RANDOMIZER,
                       "what draws values at a reset, in order"),
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
              text_field("link", "", "the link that carries it; default: the base"),
              vector_field("axis", "", {0, 0, 1}, -kFar, kFar,
                           "thrust direction in the link's frame, any length but 0"),
              required(
                  choice_field("direction", {"ccw", "cw"}, "sense of rotation about the axis")),
              real_field("min_speed", "rad/s", 0.0, -1e5, 0.0,
                         "below 0: the rotor may turn backwards to it, and then pushes against "
                         "its axis by the same constants"),
          },
          kRotorConstants)};
  return spec;
}

const MapSpec& rotors_file_fields() {
  static const MapSpec spec{
      "rotors file",
      "The rotors of one model.",
      {
          text_field("source", "", "where the constants come from"),
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
