#include "core/env/state_value_list.h"

#include <string>
#include <utility>

#include "core/env/compiled_scenario.h"
#include "core/model/held_inputs.h"
#include "core/physics/world/pose_math.h"

namespace skybody {
namespace {

/// A part of a run of values.
struct Part {
  const char* name;
  const char* unit;
  const char* frame;
  int first, count;
  const char* doc;
};

/// Parts of a BodyState.
constexpr Part kMotion[] = {
    {"position", "m", "W", 0, 3, "position of the origin"},
    {"rotation", "", "W from B", 3, 4, "unit quaternion w x y z"},
    {"velocity", "m/s", "W", 7, 3, "velocity of the origin"},
    {"angular_velocity", "rad/s", "B", 10, 3, "angular velocity relative to the world"},
};

/// Parts of a body's contact (SKYBODY_CONTACT_VALUES).
constexpr Part kContact[] = {
    {"force", "N", "W", 0, 3,
     "sum of the forces of all contacts of the body, after the last physics step"},
    {"moment", "N m", "W", 3, 3,
     "sum of the moments of these forces about the body's origin, after the last physics step"},
    {"touching", "", "", 6, 1, "1 if anything touches the body, otherwise 0"},
};

/// Texts about a joint's coordinates.
struct JointText {
  const char* unit;
  const char* velocity_unit;
  const char* doc;
  const char* velocity_doc;
};

JointText text_of(JointType type) {
  switch (type) {
    case JointType::kSlider:
      return {"m", "m/s", "travel", "rate of the travel"};
    case JointType::kBall:
      return {"", "rad/s",
              "unit quaternion w x y z, joint frame of the parent from that of the body",
              "angular velocity, axes of the body's joint frame"};
    case JointType::kUniversal:
      return {"rad", "rad/s", "angles about x, then about y", "rates of these angles"};
    default:
      return {"rad", "rad/s", "angle", "rate of the angle"};
  }
}

std::vector<int> shape_of(int count) {
  return count == 1 ? std::vector<int>{} : std::vector<int>{count};
}

class List {
 public:
  explicit List(const CompiledScenario& compiled)
      : compiled_(compiled), world_(compiled.world()), layout_(compiled.layout()) {}

  std::vector<StateValue> all() {
    add_world();
    const auto robots = static_cast<int>(world_.scenario.robots.size());
    for (int robot = 0; robot < robots; ++robot) add_robot(robot);
    add_couplings();
    add_teams();
    add_sensors();
    for (std::size_t k = 0; k < layout_.param_info.size(); ++k) {
      const EnvParam& param = layout_.param_info[k];
      add_words(param.path, param.unit, "", {layout_.params.offset + static_cast<int>(k), 1}, {},
                "drawn value");
      values_.back().alias = param.alias;
    }
    return std::move(values_);
  }

 private:
  /// Adds the value unless its block is empty in this scenario.
  void add_words_if_any(std::string path, std::string unit, const char* frame, Block block,
                        std::vector<int> shape, const char* doc) {
    if (block.size == 0) return;
    add_words(std::move(path), std::move(unit), frame, block, std::move(shape), doc);
  }

  void add_words(std::string path, std::string unit, const char* frame, Block block,
                 std::vector<int> shape, const char* doc) {
    StateValue& value = values_.emplace_back();
    value.path = std::move(path);
    value.unit = std::move(unit);
    value.frame = frame;
    value.shape = std::move(shape);
    value.doc = doc;
    value.first = block.offset;
  }

  void add_header(const char* path, const char* unit, StateSource source, HeaderWord word,
                  const char* doc) {
    add_words(path, unit, "", {word, 1}, {}, doc);
    values_.back().source = source;
  }

  /// @param bodies  more than 0: an array over that many bodies, from `body` on
  void add_motion(const std::string& prefix, int body, int bodies, const Pose& pose) {
    for (const Part& part : kMotion) {
      StateValue& value = values_.emplace_back();
      value.path = prefix + "." + part.name;
      value.unit = part.unit;
      value.frame = part.frame;
      if (bodies > 0) value.shape.push_back(bodies);
      value.shape.push_back(part.count);
      value.doc = part.doc;
      value.source = is_identity(pose) ? StateSource::kBodies : StateSource::kLink;
      value.first = body;
      value.part = part.first;
      value.pose = pose;
    }
  }

  void add_world() {
    add_header("time", "s", StateSource::kTime, kPhysicsStep, "time since the reset");
    add_header("episode", "", StateSource::kHeader, kEpisode, "number of resets so far");
    add_header("steps", "", StateSource::kHeader, kStep, "number of actions taken in this episode");
    add_header("physics_steps", "", StateSource::kHeader, kPhysicsStep,
               "number of physics steps taken in this episode");
    add_header("status", "", StateSource::kHeader, kStatus,
               "bits of the last transition: 1 terminated, 2 truncated, 4 fault; in addition to "
               "fault: 8 bad action, 16 bad state, 32 bad outcome");
    add_header("redraws", "", StateSource::kHeader, kRedraws,
               "number of repeated draws of the start of this episode, because of inertias that "
               "are not physical or robots inside something");
    add_motion("bodies", 0, static_cast<int>(world_.bodies.size()), {});
    add_block("q", "", layout_.q, "coordinates of all joints, including the bases");
    add_block("u", "", layout_.u, "velocities of all joints, including the bases");
    add_block("rotor_speed", "rad/s", layout_.rotor_speed, "speeds of all rotors of all robots");
    add_block("rotor_command", "rad/s", layout_.rotor_command,
              "commands of all rotors, constant during the last physics step");
    add_block("action", "", layout_.action, "last action, clipped to [-1, 1]");
    add_block("command", "", layout_.command,
              "commands of all chains of controllers, physical units");
  }

  void add_block(const char* path, const char* unit, Block block, const char* doc) {
    add_words(path, unit, "", block, {block.size}, doc);
  }

  void add_robot(int robot) {
    const RobotUse& use = world_.scenario.robots[static_cast<std::size_t>(robot)];
    const RobotLayout& place = layout_.robots[static_cast<std::size_t>(robot)];
    const std::string prefix = "robots." + use.name + ".";
    add_motion(prefix + "base", place.first_body, 0, {});
    for (const Link& link : use.model.links) {
      add_motion(prefix + "links." + link.name, place.first_body + link.body, 0, link.pose);
    }
    int joints = 0;
    for (int b = 0; b < place.body_count; ++b) {
      const Body& body = use.model.bodies[static_cast<std::size_t>(b)];
      if (is_moving_joint(body.joint)) add_joint(prefix, place.first_body + b, joints++);
      add_wind(prefix, place.first_body + b);
      add_contact(prefix, place.first_body + b);
    }
    add_rotors(prefix + "rotors", {place.first_rotor, place.rotor_count}, use.model.rotors);
    const Block command = compiled_.model().commands_of(robot);
    add_words_if_any(prefix + "command", "", "", command, {command.size},
                     "commands of its chains of controllers, and of teams whose first robot it is, "
                     "physical units (docs/control-modes.md)");
  }

  /// The inboard joint of a body; a base has `base` instead.
  /// @param number  among the robot's moving joints
  void add_joint(const std::string& prefix, int index, int number) {
    const WorldBody& body = world_.bodies[static_cast<std::size_t>(index)];
    const Joint& joint = body.model->joint;
    const JointText text = text_of(joint.type);
    const int q = position_size(joint.type), u = velocity_size(joint.type);
    const std::string path = prefix + "joints." + joint.name + ".";
    const std::string alias = prefix + "joints[" + std::to_string(number) + "].";
    add_words(path + "position", text.unit, "", {layout_.q.offset + body.q, q}, shape_of(q),
              text.doc);
    values_.back().alias = alias + "position";
    add_words(path + "velocity", text.velocity_unit, "", {layout_.u.offset + body.u, u},
              shape_of(u), text.velocity_doc);
    values_.back().alias = alias + "velocity";
  }

  /// The air around a body, as held by effects.
  void add_wind(const std::string& prefix, int index) {
    const Block& wind = layout_.held[SKYBODY_HELD_WIND];
    if (wind.size == 0) return;
    const std::string& link = world_.bodies[static_cast<std::size_t>(index)].model->name;
    add_words(prefix + "links." + link + ".wind", "m/s", "W", {wind.offset + 3 * index, 3}, {3},
              "velocity of the air around the body, from all effects, in the last physics step");
  }

  void add_contact(const std::string& prefix, int index) {
    if (layout_.contacts.size == 0) return;
    const WorldBody& body = world_.bodies[static_cast<std::size_t>(index)];
    const int first = layout_.contacts.offset + SKYBODY_CONTACT_VALUES * index;
    for (const Part& part : kContact) {
      add_words_if_any(prefix + "links." + body.model->name + ".contact." + part.name, part.unit,
                       part.frame, {first + part.first, part.count}, shape_of(part.count),
                       part.doc);
    }
  }

  /// @param rotors  their place within the world's rotors
  void add_rotors(const std::string& path, Block rotors, const std::vector<Rotor>& models) {
    if (rotors.size == 0) return;
    const auto add = [&](const std::string& prefix, const std::string& alias, Block place,
                         const std::vector<int>& shape) {
      add_words(prefix + ".speed", "rad/s", "",
                {layout_.rotor_speed.offset + place.offset, place.size}, shape,
                "speed; below 0: the rotor turns backwards");
      if (!alias.empty()) values_.back().alias = alias + ".speed";
      add_words(prefix + ".command", "rad/s", "",
                {layout_.rotor_command.offset + place.offset, place.size}, shape,
                "commanded speed, constant during the last physics step");
      if (!alias.empty()) values_.back().alias = alias + ".command";
    };
    add(path, "", rotors, {rotors.size});
    for (int k = 0; k < rotors.size; ++k) {
      add(path + "[" + std::to_string(k) + "]",
          path + "." + models[static_cast<std::size_t>(k)].name, {rotors.offset + k, 1}, {});
      const Block& gains = layout_.held[SKYBODY_HELD_ROTOR_GAIN];
      if (gains.size == 0) continue;
      const int size = kHeldInputs[SKYBODY_HELD_ROTOR_GAIN].size;
      const int first = gains.offset + size * (rotors.offset + k) + SKYBODY_GAIN_THRUST;
      add_words(path + "[" + std::to_string(k) + "].thrust_gain", "", "", {first, 1}, {},
                "factor on its thrust, from all effects, in the last physics step");
      values_.back().alias = path + "." + models[static_cast<std::size_t>(k)].name + ".thrust_gain";
    }
  }

  /// The command of a team's chains. Their outputs to robots' chains are under
  /// `robots.NAME.command`.
  void add_teams() {
    const std::vector<TeamUse>& teams = world_.scenario.teams;
    for (std::size_t team = 0; team < teams.size(); ++team) {
      Block command;
      for (const ControllerChain& chain : compiled_.chains()) {
        if (chain.team != static_cast<int>(team)) continue;
        if (command.size == 0) command.offset = layout_.command.offset + chain.command;
        command.size += chain.inputs;
      }
      add_words_if_any(
          "teams." + teams[team].name + ".command", "", "", command, {command.size},
          "commands of its chains of controllers, physical units (docs/control-modes.md)");
    }
  }

  void add_couplings() {
    Block pull{layout_.coupling_forces.offset, 3};
    for (const Coupling& coupling : world_.scenario.couplings) {
      add_words("couplings." + coupling.name + ".force", "N", "W", pull, {3},
                "force on the first end, in the last physics step");
      pull.offset += pull.size;
    }
  }

  void add_sensors() {
    for (const PluginInstance& sensor : compiled_.plugins(SKYBODY_SENSOR)) {
      int word = layout_.sensors.offset + sensor.sensor.output;
      for (const Channel& channel : sensor.channels) {
        if (channel.is_image()) continue;
        add_words_if_any("sensors." + sensor.name + "." + channel.name, channel.unit, "",
                         {word, channel.count}, shape_of(channel.count), "last sample");
        word += channel.count;
      }
    }
  }

  const CompiledScenario& compiled_;
  const World& world_;
  const StateLayout& layout_;
  std::vector<StateValue> values_;
};

}  // namespace

std::vector<StateValue> list_state_values(const CompiledScenario& compiled) {
  return List(compiled).all();
}

}  // namespace skybody
