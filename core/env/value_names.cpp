#include "core/env/value_names.h"

#include "core/base/system/error.h"
#include "core/base/system/suggestion.h"
#include "core/model/held_inputs.h"

namespace skybody {
namespace {

std::string indexed(const std::string& name, int k) { return name + "[" + std::to_string(k) + "]"; }

/// `name` for a single value, name[0], name[1], ... for several.
void append(std::vector<std::string>& names, const std::string& name, int count) {
  for (int k = 0; k < count; ++k) names.push_back(count == 1 ? name : indexed(name, k));
}

/// The columns of the row of observations, or of the privileged row.
void append_observation(std::vector<std::string>& names, const std::string& prefix,
                        const CompiledScenario& compiled, bool privileged) {
  for (const ObservationColumn& column : compiled.columns()) {
    if (column.image >= 0) continue;
    if (column.privileged == privileged) append(names, prefix + column.name, column.count());
  }
}

/// Names the words one by one, in the order of the layout.
class StateNames {
 public:
  explicit StateNames(const CompiledScenario& compiled)
      : compiled_(compiled), layout_(compiled.layout()) {}

  std::vector<std::string> all() {
    names_ = {"seed",  "stream_env", "episode",  "step",   "physics_step",
              "forks", "status",     "requests", "redraws"};
    expect(layout_.q);
    name_coordinates(layout_.q, "q", [](const WorldBody& body) { return body.q; });
    name_coordinates(layout_.u, "u", [](const WorldBody& body) { return body.u; });
    name_rotors(layout_.rotor_speed, "rotor_speed ");
    name_rotors(layout_.rotor_command, "rotor_command ");
    name_block(layout_.wrench, "wrench");
    name_block(layout_.drive, "drive");
    name_block(layout_.joint_command, "joint_command");
    name_block(layout_.joint_state, "joint_state");
    name_block(layout_.coupling_forces, "coupling_forces");
    name_block(layout_.bristles, "bristles");
    for (std::size_t i = 0; i < layout_.held.size(); ++i) {
      name_block(layout_.held[i], std::string("held ") + kHeldInputs[i].name);
    }
    name_block(layout_.bodies_before, "bodies_before");
    expect(layout_.params);
    for (const EnvParam& param : layout_.param_info) names_.push_back("params " + param.path);
    name_block(layout_.action, "action");
    name_block(layout_.command, "command");
    name_sensors();
    name_block(layout_.contacts, "contacts");
    name_block(layout_.contact_pairs, "contact_pairs");
    name_block(layout_.joint_reactions, "joint_reactions");
    name_block(layout_.plugin_state, "plugin_state");
    expect(layout_.last_observation);
    append_observation(names_, "last_observation ", compiled_, false);
    append_observation(names_, "last_observation ", compiled_, true);
    SKYBODY_DEMAND(static_cast<int>(names_.size()) == layout_.words, "words without a name");
    return std::move(names_);
  }

 private:
  void expect(Block block) const {
    SKYBODY_DEMAND(block.size == 0 || block.offset == static_cast<int>(names_.size()),
                   "names of state words are out of step with the layout");
  }

  void name_block(Block block, const std::string& name) {
    expect(block);
    for (int k = 0; k < block.size; ++k) names_.push_back(indexed(name, k));
  }

  template <class First>
  void name_coordinates(Block block, const std::string& name, First&& first) {
    expect(block);
    const std::vector<WorldBody>& bodies = compiled_.world().bodies;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const int end = b + 1 < bodies.size() ? first(bodies[b + 1]) : block.size;
      const std::string body = robot_name(bodies[b].robot) + "." + bodies[b].model->name;
      for (int k = first(bodies[b]); k < end; ++k) {
        names_.push_back(indexed(name + " " + body, k - first(bodies[b])));
      }
    }
  }

  void name_rotors(Block block, const std::string& prefix) {
    expect(block);
    for (const WorldRotor& rotor : compiled_.world().rotors) {
      names_.push_back(prefix + robot_name(rotor.robot) + "." + rotor.model->name);
    }
  }

  void name_sensors() {
    expect(layout_.sensors);
    for (const PluginInstance& sensor : compiled_.plugins(SKYBODY_SENSOR)) {
      for (const Channel& channel : sensor.channels) {
        if (channel.is_image()) continue;
        append(names_, "sensors " + sensor.name + "." + channel.name, channel.count);
      }
    }
  }

  std::string robot_name(int robot) const {
    return compiled_.scenario().robots[static_cast<std::size_t>(robot)].name;
  }

  const CompiledScenario& compiled_;
  const StateLayout& layout_;
  std::vector<std::string> names_;
};

}  // namespace

std::vector<std::string> state_names(const CompiledScenario& compiled) {
  return StateNames(compiled).all();
}

std::vector<std::string> observation_names(const CompiledScenario& compiled) {
  std::vector<std::string> names;
  append_observation(names, "", compiled, false);
  return names;
}

std::string source_of(const CompiledScenario& compiled, const ObservationColumn& column) {
  if (column.source.sensor < 0) return "task";
  const PluginInstance& sensor =
      compiled.plugins(SKYBODY_SENSOR)[static_cast<std::size_t>(column.source.sensor)];
  return sensor.name + "." + sensor.channels[static_cast<std::size_t>(column.source.channel)].name;
}

std::vector<std::string> column_texts(const CompiledScenario& compiled) {
  std::vector<std::string> texts;
  for (const ObservationColumn& column : compiled.columns()) {
    std::vector<std::string> shape;
    for (const int extent : column.shape) shape.push_back(std::to_string(extent));
    texts.push_back(column.name + " " + info_of(column.type).name + " [" + join(shape) + "] from " +
                    source_of(compiled, column) + (column.privileged ? ", privileged" : ""));
  }
  return texts;
}

std::vector<std::string> privileged_names(const CompiledScenario& compiled) {
  std::vector<std::string> names;
  append_observation(names, "", compiled, true);
  return names;
}

}  // namespace skybody
