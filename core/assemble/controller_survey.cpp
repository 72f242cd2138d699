#include "core/assemble/controller_survey.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/assemble/trajectory_chain.h"
#include "core/base/system/error.h"
#include "core/base/system/suggestion.h"
#include "core/env/check_declarations.h"
#include "core/env/controller_chains.h"
#include "core/env/plugin_setup_tables.h"
#include "core/plugin_host/instance.h"

namespace skybody {
namespace {

/// With more combinations than this, only single parameters are changed.
constexpr std::size_t kMostCombinations = 64;

/// One choice for each choice parameter: indices into words_of().
using Words = std::vector<std::size_t>;

/// A value within the range of a parameter without a default.
double some_number(const ParameterSpec& spec) {
  double value = 1.0;
  if (std::isfinite(spec.max)) value = std::min(value, spec.max);
  if (std::isfinite(spec.min)) value = std::max(value, spec.min);
  return value;
}

/// The robot's first moving joint, or "".
std::string first_joint(const Topology& topology, int robot) {
  for (const Body& body : topology.scenario.robots[static_cast<std::size_t>(robot)].model.bodies) {
    if (is_moving_joint(body.joint)) return body.joint.name;
  }
  return "";
}

/// Configures one controller in all of its combinations.
class Survey {
 public:
  Survey(const Topology& topology, int robot)
      : topology_(topology),
        plan_(topology),
        tables_(topology, plan_.layout),
        robot_(robot),
        joint_(first_joint(topology, robot)) {}

  void add(const PluginEntry& entry, ControllerSurvey& survey) const {
    std::string reason;
    const std::size_t before = survey.modes.size();
    for (const Words& words : combinations(entry)) {
      ControllerMode mode;
      mode.plugin = entry.name;
      mode.doc = entry.doc;
      if (const std::string failure = try_out(entry, words, mode); !failure.empty()) {
        if (reason.empty()) reason = failure;
      } else if (is_new(survey.modes, before, mode)) {
        survey.modes.push_back(std::move(mode));
      }
    }
    if (survey.modes.size() == before) survey.refused.push_back({entry.name, reason});
  }

 private:
  /// The allowed words of a choice parameter; empty for other parameters.
  static std::vector<std::string> words_of(const ParameterSpec& spec) {
    if (!spec.is_scalar()) return {};
    if (spec.type == ParameterType::kBoolean) return {"false", "true"};
    return spec.choices.size() > 1 ? spec.choices : std::vector<std::string>{};
  }

  static std::vector<const ParameterSpec*> word_parameters(const PluginEntry& entry) {
    std::vector<const ParameterSpec*> specs;
    for (const ParameterSpec& spec : entry.parameters) {
      if (!words_of(spec).empty()) specs.push_back(&spec);
    }
    return specs;
  }

  static std::size_t default_word(const ParameterSpec& spec) {
    if (spec.type == ParameterType::kBoolean) {
      return !spec.default_numbers.empty() && spec.default_numbers[0] != 0.0 ? 1 : 0;
    }
    if (spec.default_texts.empty()) return 0;
    const auto found = std::find(spec.choices.begin(), spec.choices.end(), spec.default_texts[0]);
    return found == spec.choices.end() ? 0 : static_cast<std::size_t>(found - spec.choices.begin());
  }

  static std::size_t differences(const Words& a, const Words& b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i] ? 1 : 0;
    return count;
  }

  /// All combinations, in ascending order of their changes from the defaults.
  static std::vector<Words> combinations(const PluginEntry& entry) {
    const std::vector<const ParameterSpec*> specs = word_parameters(entry);
    Words defaults;
    std::size_t count = 1;
    for (const ParameterSpec* spec : specs) {
      defaults.push_back(default_word(*spec));
      count = std::min(count * words_of(*spec).size(), kMostCombinations + 1);
    }
    std::vector<Words> all{defaults};
    for (std::size_t i = 0; i < specs.size(); ++i) {
      const std::size_t so_far = count <= kMostCombinations ? all.size() : 1;
      for (std::size_t k = 0; k < so_far; ++k) {
        for (std::size_t word = 0; word < words_of(*specs[i]).size(); ++word) {
          if (word == defaults[i]) continue;
          Words changed = all[k];
          changed[i] = word;
          all.push_back(std::move(changed));
        }
      }
    }
    std::stable_sort(all.begin(), all.end(), [&](const Words& a, const Words& b) {
      return differences(a, defaults) < differences(b, defaults);
    });
    return all;
  }

  /// The values filled in for a controller that rejects its defaults.
  enum class Filling { kRequired, kNames, kNamesAndZeros, kTables };

  ParameterValue value_of(const ParameterSpec& spec, Filling filling) const {
    ParameterValue value;
    value.name = spec.name;
    value.type = spec.type;
    value.numbers = spec.default_numbers;
    value.texts = spec.default_texts;
    value.is_given = false;
    const auto count = static_cast<std::size_t>(std::max(1, spec.min_count));
    if (spec.type == ParameterType::kText) {
      const bool is_name = spec.choices.empty() && !spec.is_file && !joint_.empty();
      if (spec.required && !spec.choices.empty()) value.texts.assign(count, spec.choices[0]);
      if (is_name && (spec.required || (filling != Filling::kRequired && !spec.is_scalar()))) {
        value.texts.assign(count, joint_);
      }
      return value;
    }
    if (spec.required && filling == Filling::kTables && spec.max_count < 0) {
      value.numbers = spec.unit == "s" ? std::vector<double>{0.0, 1.0} : std::vector<double>(6);
      return value;
    }
    const bool is_zero = spec.type == ParameterType::kReal && spec.is_scalar() && spec.min == 0.0 &&
                         spec.default_numbers == std::vector<double>{0.0};
    if (spec.required || (is_zero && filling == Filling::kNamesAndZeros)) {
      value.numbers.assign(count, some_number(spec));
    }
    return value;
  }

  static void choose(ParameterValue& value, const std::string& word, std::size_t place) {
    value.is_given = true;
    if (value.type == ParameterType::kBoolean) {
      value.numbers = {static_cast<double>(place)};
    } else {
      value.texts = {word};
    }
  }

  /// @returns the plugin's reason for rejecting the configuration, or ""
  std::string try_out(const PluginEntry& entry, const Words& words, ControllerMode& mode) const {
    std::string reason;
    for (const Filling filling :
         {Filling::kRequired, Filling::kNames, Filling::kNamesAndZeros, Filling::kTables}) {
      reason = try_out(entry, words, filling, mode);
      if (reason.empty()) return "";
    }
    return reason;
  }

  std::string try_out(const PluginEntry& entry, const Words& words, Filling filling,
                      ControllerMode& mode) const {
    mode.options.clear();
    std::vector<ParameterValue> values;
    std::size_t at = 0;
    for (const ParameterSpec& spec : entry.parameters) {
      values.push_back(value_of(spec, filling));
      const std::vector<std::string> choices = words_of(spec);
      if (choices.empty()) continue;
      const std::size_t chosen = words[at++];
      if (chosen == default_word(spec) && !spec.required) continue;
      mode.options.push_back(spec.name + ": " + choices[chosen]);
      choose(values.back(), choices[chosen], chosen);
    }
    try {
      configure(entry, values, mode);
    } catch (const Error& refusal) {
      return refusal.what();
    }
    return "";
  }

  void configure(const PluginEntry& entry, const std::vector<ParameterValue>& values,
                 ControllerMode& mode) const {
    const RobotUse& use = topology_.scenario.robots[static_cast<std::size_t>(robot_)];
    PluginInstance instance;
    instance.kind = SKYBODY_CONTROLLER;
    instance.plugin = entry.name;
    instance.controller.team = {robot_};
    const BoundValues bound(values);
    const SkybodyDeclare declare = declare_into(instance);
    const std::string path = "robots." + use.name + ".controllers." + entry.name;
    const SkybodySetup setup = tables_.setup(path, instance.controller.team, bound.table());
    instance.self = create_instance(entry, setup, declare);
    check_declarations(topology_, plan_.layout, instance);
    mode.takes = {instance.controller.input_signal, instance.controller.input_count()};
    mode.gives = {instance.controller.outputs[0].signal, instance.controller.outputs[0].count};
    mode.acts = acts(instance);
    mode.low = instance.controller.low;
    mode.high = instance.controller.high;
    mode.passes_on = instance.controller.passes_on;
    if (mode.passes_on) mode.options.clear();
  }

  /// A wrench needs a site and a joint command needs a drive. Without them the output is the input
  /// of another controller.
  static bool acts(const PluginInstance& instance) {
    const int signal = instance.controller.outputs[0].signal;
    if (signal == SKYBODY_WRENCH) return !instance.controller.sites.empty();
    if (signal == SKYBODY_JOINT) return !instance.controller.joints.empty();
    return actuates(signal);
  }

  static bool is_new(const std::vector<ControllerMode>& modes, std::size_t first,
                     const ControllerMode& mode) {
    if (mode.passes_on) return modes.size() == first;
    return std::none_of(modes.begin() + static_cast<std::ptrdiff_t>(first), modes.end(),
                        [&](const ControllerMode& other) {
                          return other.takes.signal == mode.takes.signal &&
                                 other.takes.count == mode.takes.count &&
                                 other.gives.signal == mode.gives.signal &&
                                 other.gives.count == mode.gives.count;
                        });
  }

  const Topology& topology_;
  const WorldPlan plan_;
  const SetupTables tables_;
  int robot_;
  std::string joint_;
};

MassProperties box_mass(double mass, const Vec3<double>& size) {
  const auto moment = [mass](double a, double b) { return mass * (a * a + b * b) / 12.0; };
  return {mass,
          {0.0, 0.0, 0.0},
          {moment(size.y, size.z), moment(size.x, size.z), moment(size.x, size.y), 0.0, 0.0, 0.0}};
}

Rotor survey_rotor(int number) {
  const double x = number < 2 ? 0.1 : -0.1, y = number % 2 == 0 ? 0.1 : -0.1;
  Rotor rotor;
  rotor.name = "rotor" + std::to_string(number);
  rotor.direction = x * y > 0.0 ? 1 : -1;
  rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT] = 2e-6;
  rotor.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] = 3e-8;
  rotor.constants[SKYBODY_ROTOR_MAX_SPEED] = 2200.0;
  rotor.constants[SKYBODY_ROTOR_TAU_UP] = 0.0125;
  rotor.constants[SKYBODY_ROTOR_TAU_DOWN] = 0.025;
  rotor.set_position({x, y, 0.0});
  return rotor;
}

/// Whether a controller with the input `level` can follow a chain that begins with `from`.
bool fits(const ControllerSurvey& survey, const std::vector<int>& row, const Level& from,
          const Level& level) {
  const Level& given =
      row.empty() ? from : survey.modes[static_cast<std::size_t>(row.back())].gives;
  return given.signal == level.signal && (given.count == 0 || given.count == level.count);
}

/// With a task that has a trajectory, `signal: position` is not the default of `position`.
void say_default_of_position(ControllerSurvey& survey) {
  for (ControllerMode& mode : survey.modes) {
    if (mode.plugin != "position" || mode.takes.signal != SKYBODY_POSITION) continue;
    mode.options.emplace_back("signal: position");
  }
}

}  // namespace

ControllerSurvey survey_controllers(const std::vector<const PluginEntry*>& entries,
                                    const Topology& topology, int robot) {
  ControllerSurvey survey;
  const Survey way(topology, robot);
  for (const PluginEntry* entry : entries) way.add(*entry, survey);
  if (has_trajectory(topology.scenario.task)) say_default_of_position(survey);
  return survey;
}

Topology survey_vehicle() {
  RobotModel model;
  model.name = "survey";
  model.bodies.resize(2);
  model.bodies[0].name = "base";
  model.bodies[0].mass = box_mass(1.0, {0.2, 0.2, 0.05});
  model.bodies[1].name = "arm";
  model.bodies[1].mass = box_mass(0.1, {0.2, 0.02, 0.02});
  Joint& joint = model.bodies[1].joint;
  joint.name = "elbow";
  joint.type = JointType::kPin;
  joint.parent = 0;
  joint.limit = {true, -1.0, 1.0};
  for (int i = 0; i < 2; ++i) {
    model.links.push_back({model.bodies[static_cast<std::size_t>(i)].name, i, {}, {}});
  }
  for (int i = 0; i < 4; ++i) model.rotors.push_back(survey_rotor(i));
  Scenario scenario;
  scenario.name = "survey";
  RobotUse& robot = scenario.robots.emplace_back();
  robot.name = "vehicle";
  robot.model = std::move(model);
  return Topology(std::move(scenario));
}

std::vector<int> shortest_chain(const ControllerSurvey& survey, const Level& from, int to) {
  // Uniform-cost search. Options that differ from the defaults add to the cost: of chains of equal
  // length, those with default options come first.
  struct Row {
    std::vector<int> modes;
    int cost = 0;
  };
  std::vector<Row> open{{}};
  std::set<std::pair<int, int>> done;
  while (!open.empty()) {
    const auto least = std::min_element(open.begin(), open.end(),
                                        [](const Row& a, const Row& b) { return a.cost < b.cost; });
    const Row row = *least;
    open.erase(least);
    if (!row.modes.empty()) {
      const ControllerMode& last = survey.modes[static_cast<std::size_t>(row.modes.back())];
      const Level& given = last.gives;
      if (to < 0 ? last.acts : given.signal == to) return row.modes;
      const bool is_back = given.signal == from.signal;
      if (is_back || !done.insert({given.signal, given.count}).second) continue;
    }
    for (int i = 0; i < static_cast<int>(survey.modes.size()); ++i) {
      const ControllerMode& mode = survey.modes[static_cast<std::size_t>(i)];
      if (mode.passes_on || !fits(survey, row.modes, from, mode.takes)) continue;
      Row longer = row;
      longer.modes.push_back(i);
      longer.cost += 2 + 3 * static_cast<int>(mode.options.size());
      open.push_back(std::move(longer));
    }
  }
  return {};
}

std::string chain_text(const ControllerSurvey& survey, const std::vector<int>& chain) {
  std::string text;
  for (const int i : chain) {
    const ControllerMode& mode = survey.modes[static_cast<std::size_t>(i)];
    text += (text.empty() ? "`" : ", then `") + mode.plugin + "`";
    if (!mode.options.empty()) text += " (`" + join(mode.options, "`, `") + "`)";
  }
  return text;
}

std::string chain_yaml(const ControllerSurvey& survey, const std::vector<int>& chain) {
  std::string text;
  for (const int i : chain) {
    const ControllerMode& mode = survey.modes[static_cast<std::size_t>(i)];
    text += (text.empty() ? "{plugin: " : ", {plugin: ") + mode.plugin;
    if (!mode.options.empty()) text += ", parameters: {" + join(mode.options) + "}";
    text += "}";
  }
  return "[" + text + "]";
}

}  // namespace skybody
