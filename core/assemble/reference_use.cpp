#include "core/assemble/reference_use.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/assemble/trajectory_chain.h"
#include "core/base/system/suggestion.h"
#include "core/env/controller_chains.h"
#include "core/io/files/file.h"
#include "core/io/files/shipped_files.h"
#include "core/io/files/text.h"
#include "core/plugin_abi/abi.h"

namespace skybody {
namespace {

constexpr const char* kNameSeparator = ":";

/// A controller with parameters, in the syntax of scenarios.
using Use = const char*;

/// The controllers between a reference and the first controller of a chain.
struct Lead {
  int signal;         ///< input of the chain
  int count;          ///< number of its values; 0: any
  const char* gives;  ///< the reference's parameter `gives`
  std::vector<Use> controllers;
};

// `position` limits positions to the range of actions, and accelerations to values that suit a
// learner. A reference is not an action and was checked against the vehicle's limits, so it may
// exceed them. Trajectory controllers have no such range; their limits follow from the rotors'
// thrust.
#define SKYBODY_FREE_PLACE "position_min: [-1e5, -1e5, -1e5], position_max: [1e5, 1e5, 1e5]"
#define SKYBODY_FREE_PACE \
  "max_acceleration_side: 30, max_acceleration_up: 30, max_acceleration_down: 8"

/// Values of `attitude` with the desired attitude's rates.
constexpr int kAttitudeAndRates = 8;

/// One row per signal that a reference can command. The controllers of a row close the position
/// loop and use the reference's derivatives if the chain accepts them.
const std::vector<Lead> kLeads = {
    {SKYBODY_TRAJECTORY, 0, "trajectory", {}},
    {SKYBODY_POSITION, 0, "position", {}},
    {SKYBODY_VELOCITY_TRACKING, 0, "velocity_tracking", {}},
    {SKYBODY_ACCELERATION, 0, "acceleration", {}},
    {SKYBODY_ATTITUDE,
     kAttitudeAndRates,
     "trajectory",
     {"{plugin: position, parameters: {signal: trajectory, " SKYBODY_FREE_PACE "}}"}},
    {SKYBODY_ATTITUDE,
     5,
     "position",
     {"{plugin: position, parameters: {" SKYBODY_FREE_PLACE ", " SKYBODY_FREE_PACE "}}"}},
    {SKYBODY_CTBR, 0, "trajectory", {"{plugin: geometric, parameters: {output: ctbr}}"}},
    {SKYBODY_CTBT, 0, "trajectory", {"{plugin: geometric, parameters: {output: ctbt}}"}},
    {SKYBODY_ROTOR_SPEED,
     0,
     "trajectory",
     {"{plugin: geometric, parameters: {output: ctbt}}", "{plugin: ctbt}"}},
    {SKYBODY_SRT,
     0,
     "trajectory",
     {"{plugin: nmpc, parameters: {preview: true, horizon: 20, node_step: 0.05}}"}},
};

#undef SKYBODY_FREE_PACE
#undef SKYBODY_FREE_PLACE

/// The parsed command-line option.
struct Asked {
  ConfigNode parameters;  ///< of the controller `reference`
  std::string robot;      ///< empty: not given
};

/// Splits at commas outside of brackets.
std::vector<std::string> split_options(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (c == ',' && depth == 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

class Request {
 public:
  Request(const std::string& text, Diagnostics& diagnostics)
      : text_(text), mark_{kReferencePrefix + text, 0, 0}, diagnostics_(diagnostics) {}

  std::optional<Asked> read() {
    const int errors_before = diagnostics_.error_count();
    const std::size_t colon = text_.find(kNameSeparator);
    Asked asked;
    std::optional<ConfigNode> file = load(text_.substr(0, colon));
    if (!file) return std::nullopt;
    asked.parameters = std::move(*file);
    if (colon != std::string::npos) {
      for (const std::string& option : split_options(text_.substr(colon + 1))) {
        take(option, asked);
      }
    }
    if (diagnostics_.error_count() > errors_before) return std::nullopt;
    return asked;
  }

 private:
  std::optional<ConfigNode> load(const std::string& name) {
    std::string file = name;
    if (is_identifier(name)) {
      const auto shipped = find_shipped_reference(name);
      if (!shipped) {
        diagnostics_.error(mark_, "`" + name + "` is neither a shipped reference nor a YAML file" +
                                      suggestion(name, shipped_references(), "shipped"));
        return std::nullopt;
      }
      file = shipped->string();
    }
    std::optional<ConfigNode> root = load_config(file, diagnostics_);
    if (root && !root->is_map()) {
      diagnostics_.error(root->mark, "a reference is " + root->describe() +
                                         "; allowed: a map of parameters of `reference`");
      return std::nullopt;
    }
    return root;
  }

  void take(const std::string& option, Asked& asked) {
    const std::size_t equals = option.find('=');
    if (equals == std::string::npos || equals == 0) {
      diagnostics_.error(mark_, "`" + option + "` is no key=value, as in `peak_speed=2`");
      return;
    }
    const std::string key = option.substr(0, equals);
    const auto value = parse_yaml(option.substr(equals + 1), mark_.file, diagnostics_);
    if (!value) return;
    if (key == "robot") {
      asked.robot = value->scalar;
    } else if (ConfigNode* old = asked.parameters.find(key)) {
      *old = *value;
    } else {
      asked.parameters.entries.push_back({key, mark_, *value});
    }
  }

  const std::string& text_;
  SourceLocation mark_;
  Diagnostics& diagnostics_;
};

const std::string& robot_of(const CompiledScenario& compiled, const ControllerChain& chain) {
  return compiled.scenario().robots[static_cast<std::size_t>(chain.robot)].name;
}

/// The chains that a reference can command, of the robot called `name` or of all robots: chains
/// that end at rotors or move a base.
std::vector<const ControllerChain*> find_chains(const CompiledScenario& compiled,
                                                const std::string& name) {
  std::vector<const ControllerChain*> found;
  for (const ControllerChain& chain : compiled.chains()) {
    const bool is_usable = chain.team < 0 && !chain.is_fed && chain.signal != SKYBODY_NONE &&
                           chain.signal != SKYBODY_JOINT;
    if (is_usable && (name.empty() || robot_of(compiled, chain) == name)) found.push_back(&chain);
  }
  return found;
}

/// The robots of the chains, each once, for an error message; empty if there is only one.
std::string several_robots(const CompiledScenario& compiled,
                           const std::vector<const ControllerChain*>& chains) {
  std::string text;
  int robot = -1, count = 0;
  for (const ControllerChain* chain : chains) {
    if (chain->robot == robot) continue;
    robot = chain->robot;
    text += (count++ == 0 ? "" : ", ") + robot_of(compiled, *chain);
  }
  return count > 1 ? text : "";
}

ConfigNode text_node(const std::string& text, const SourceLocation& mark) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kScalar;
  node.mark = mark;
  node.scalar = text;
  return node;
}

ConfigNode plugin_node(const std::string& plugin, const SourceLocation& mark) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kMap;
  node.mark = mark;
  node.entries.push_back({"plugin", mark, text_node(plugin, mark)});
  return node;
}

void set(ConfigNode& map, const std::string& key, ConfigNode value) {
  const SourceLocation mark = value.mark;
  if (ConfigNode* old = map.find(key)) {
    *old = std::move(value);
  } else {
    map.entries.push_back({key, mark, std::move(value)});
  }
}

/// The position of the inserted controllers.
struct RobotPlace {
  std::size_t robot;       ///< index
  std::size_t controller;  ///< within the robot's controllers
  std::string name;        ///< of the robot
  std::string base;        ///< its base link
};

RobotPlace place_of(const CompiledScenario& compiled, const ControllerChain& chain) {
  const auto robot = static_cast<std::size_t>(chain.robot);
  const RobotUse& use = compiled.scenario().robots[robot];
  const auto controller = &first_controller(compiled, chain) - use.controllers.data();
  return {robot, static_cast<std::size_t>(controller), use.name, use.model.bodies[0].name};
}

/// Removes draws of the task's parameters: another task replaces it.
void drop_draws_of_task(ConfigNode& root) {
  ConfigNode* randomization = root.find("randomization");
  if (randomization == nullptr) return;
  const auto is_of_task = [](const ConfigNode& path) {
    return path.scalar == "task" || path.scalar.starts_with("task.");
  };
  std::erase_if(randomization->items, [&](ConfigNode& use) {
    ConfigNode* parameters = use.find("parameters");
    if (parameters == nullptr) return false;
    const ConfigNode* path = parameters->find("reference");  // of `lissajous`
    if (path != nullptr && is_of_task(*path)) return true;
    ConfigNode* what = parameters->find("what");
    if (what == nullptr) return false;
    if (what->is_scalar()) return is_of_task(*what);
    return std::erase_if(what->items, is_of_task) > 0 && what->items.empty();
  });
}

/// The controllers of a lead, with their downward acceleration limited below gravity.
/// @param gravity  [m/s^2]
std::vector<ConfigNode> controllers_of(const Lead& lead, double gravity,
                                       const SourceLocation& mark) {
  constexpr double kShare = 0.89;  // controllers reject more than 0.9
  std::vector<ConfigNode> out;
  Diagnostics none;  // these texts are constants
  for (const Use use : lead.controllers) {
    out.push_back(*parse_yaml(use, mark.file, none));
    ConfigNode* parameters = out.back().find("parameters");
    ConfigNode* down = parameters == nullptr ? nullptr : parameters->find("max_acceleration_down");
    if (down != nullptr && kShare * gravity < std::stod(down->scalar)) {
      down->scalar = std::to_string(kShare * gravity);
    }
  }
  return out;
}

/// Number and spacing of the trajectory points that the reference outputs.
struct Preview {
  std::string points = "1";
  std::string spacing;  ///< [s]; empty: the default of `reference`
};

/// The preview of the first trajectory controller: `nmpc` takes one point per node and the current
/// one; other controllers take one point.
Preview preview_of(const CompiledScenario& compiled, const ControllerChain& chain,
                   const std::vector<ConfigNode>& controllers) {
  Preview preview;
  if (chain.signal == SKYBODY_TRAJECTORY) {
    preview.points = std::to_string(chain.inputs / SKYBODY_REFERENCE_VALUES);
    const double spacing = point_spacing(first_controller(compiled, chain));
    if (spacing > 0.0) preview.spacing = format_number(spacing);
  } else if (!controllers.empty()) {
    const ConfigNode& parameters = *controllers[0].find("parameters");
    const ConfigNode *horizon = parameters.find("horizon"), *step = parameters.find("node_step");
    if (horizon != nullptr) preview.points = std::to_string(std::stoi(horizon->scalar) + 1);
    if (step != nullptr) preview.spacing = step->scalar;
  }
  return preview;
}

void set_parameter(ConfigNode& use, const char* name, const char* value,
                   const SourceLocation& mark) {
  ConfigNode* parameters = use.find("parameters");
  if (parameters == nullptr || !parameters->is_map()) {
    ConfigNode none;
    none.kind = ConfigNode::Kind::kMap;
    none.mark = mark;
    set(use, "parameters", std::move(none));
    parameters = use.find("parameters");
  }
  set(*parameters, name, text_node(value, mark));
}

void apply(const TrajectoryChain& open, ConfigNode* chain, const SourceLocation& mark) {
  if (open.position) set_parameter(chain[0], "signal", "trajectory", mark);
  if (!open.attitude) return;
  set_parameter(chain[open.position ? 1 : 0], "feed_forward", "true", mark);
}

/// @param more_controllers  between the reference and the chain
/// @param parameters        of the controller `reference`, with `gives`
void put_in(ConfigNode& root, const RobotPlace& place, const TrajectoryChain& open,
            const std::vector<ConfigNode>& more_controllers, const ConfigNode& parameters,
            const SourceLocation& mark) {
  ConfigNode& controllers = *root.find("robots")->items[place.robot].find("controllers");
  apply(open, &controllers.items[place.controller], mark);
  ConfigNode reference = plugin_node("reference", mark);
  reference.entries.push_back({"parameters", mark, parameters});
  std::vector<ConfigNode> more = {std::move(reference)};
  more.insert(more.end(), more_controllers.begin(), more_controllers.end());
  controllers.items.insert(
      controllers.items.begin() + static_cast<std::ptrdiff_t>(place.controller), more.begin(),
      more.end());
  ConfigNode task = plugin_node("watch", mark), watched;
  watched.kind = ConfigNode::Kind::kMap;
  watched.mark = mark;
  set(watched, "robot", text_node(place.name, mark));
  set(watched, "link", text_node(place.base, mark));
  set(task, "parameters", std::move(watched));
  set(root, "task", std::move(task));
  drop_draws_of_task(root);
  ConfigNode* stepping = root.find("stepping");
  if (stepping != nullptr && stepping->is_map()) set(*stepping, "horizon", text_node("0", mark));
}

std::string signals_with_leads() {
  std::string text;
  for (const Lead& lead : kLeads) {
    const std::string name = signal_name(lead.signal);
    if (text.find(name) != std::string::npos) continue;
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

}  // namespace

ScenarioEdit reference_edit(const std::string& text, const CompiledScenario& compiled,
                            Diagnostics& diagnostics) {
  const SourceLocation mark{kReferencePrefix + text, 0, 0};
  std::optional<Asked> asked = Request(text, diagnostics).read();
  if (!asked) return {};
  const std::vector<const ControllerChain*> chains = find_chains(compiled, asked->robot);
  if (const std::string robots = several_robots(compiled, chains); !robots.empty()) {
    diagnostics.error(mark, "several robots could fly the reference: " + robots +
                                "; name one, as in `robot=" + robot_of(compiled, *chains[0]) + "`");
    return {};
  }
  if (chains.empty()) {
    diagnostics.error(
        mark, (asked->robot.empty() ? "no robot"
                                    : "`robot` is `" + asked->robot + "`, which is no robot or") +
                  std::string(" has a chain of its own that actions command: give "
                              "it controllers, or name another robot"));
    return {};
  }
  const ControllerChain* chain = chains[0];
  const RobotPlace place = place_of(compiled, *chain);
  const TrajectoryChain open =
      open_trajectory_chain(&first_controller(compiled, *chain), chain->count);
  const int signal = open.position ? SKYBODY_TRAJECTORY : chain->signal;
  const int inputs = open.any() && !open.position ? kAttitudeAndRates : chain->inputs;
  const auto lead = std::find_if(kLeads.begin(), kLeads.end(), [&](const Lead& l) {
    return l.signal == signal && (l.count == 0 || l.count == inputs);
  });
  if (lead == kLeads.end()) {
    diagnostics.error(mark, "the chain of robot `" + place.name + "` takes " +
                                signal_name(chain->signal) +
                                ", to which no controller leads from a reference; allowed: " +
                                signals_with_leads() + "; begin the chain with one of these");
    return {};
  }
  set(asked->parameters, "gives", text_node(lead->gives, mark));
  const std::vector<ConfigNode> controllers =
      controllers_of(*lead, norm(compiled.scenario().gravity()), mark);
  const Preview preview = preview_of(compiled, *chain, controllers);
  const auto by_default = [&](const std::string& key, const std::string& value) {
    if (asked->parameters.find(key) == nullptr) set(asked->parameters, key, text_node(value, mark));
  };
  by_default("points", preview.points);
  if (!preview.spacing.empty()) by_default("spacing", preview.spacing);
  return [place, open, controllers, parameters = asked->parameters, mark](ConfigNode& root,
                                                                          Diagnostics&) {
    put_in(root, place, open, controllers, parameters, mark);
  };
}

}  // namespace skybody
