#include "app/report/mode_tables.h"

#include <algorithm>
#include <cmath>

#include "app/report/rounded.h"
#include "app/report/text_table.h"
#include "core/io/files/json.h"
#include "core/io/files/text.h"

namespace skybody {
namespace {

std::string with_size(int signal, int count) {
  if (signal == SKYBODY_NONE) return signal_name(signal);
  return std::string(signal_name(signal)) + "[" + std::to_string(count) + "]";
}

std::string range_of(double low, double high) {
  if (low == -high && high > 0.0) return "+-" + rounded(high);
  return rounded(low) + ".." + rounded(high);
}

constexpr std::size_t kMostRanges = 8;  // for a signal of many points each point repeats them

/// "0..35.3, 2 x +-10, +-5": equal neighbours are combined.
std::string ranges_text(const std::vector<double>& low, const std::vector<double>& high) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < low.size();) {
    std::size_t end = i;
    while (end < low.size() && low[end] == low[i] && high[end] == high[i]) ++end;
    const std::string range = range_of(low[i], high[i]);
    parts.push_back(end - i == 1 ? range : std::to_string(end - i) + " x " + range);
    i = end;
  }
  if (parts.size() > kMostRanges) {
    parts.resize(kMostRanges);
    parts.emplace_back("...");
  }
  return parts.empty() ? "takes no command" : join(parts);
}

std::string numbers_json(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) {
    texts.push_back(std::isfinite(value) ? format_number(value) : "null");
  }
  return json_array(texts);
}

JsonObject level_json(int signal, int count) {
  JsonObject level;
  level.set_text("signal", signal_name(signal)).set("size", std::to_string(count));
  return level;
}

std::string texts_json(const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(json_string(text));
  return json_array(quoted);
}

std::string signal_table() {
  TextTable table({"level", "values", "acts"});
  for (int signal = 0; signal < SKYBODY_SIGNAL_COUNT; ++signal) {
    if (signal == SKYBODY_NONE) continue;
    table.add({signal_name(signal), signal_meaning(signal), actuates(signal) ? "yes" : ""});
  }
  return table.to_string();
}

/// For each mode, the chains that begin with it and end at rotors, or at other actuators if none
/// ends at rotors, by their first level; values are indices in the survey.
std::vector<std::vector<int>> entries_of(const ControllerSurvey& survey) {
  std::vector<std::vector<int>> entries;
  for (int i = 0; i < static_cast<int>(survey.modes.size()); ++i) {
    const ControllerMode& mode = survey.modes[static_cast<std::size_t>(i)];
    if (mode.passes_on || mode.takes.signal == SKYBODY_NONE) continue;
    std::vector<int> chain{i};
    if (!mode.acts) {
      std::vector<int> rest = shortest_chain(survey, mode.gives, SKYBODY_ROTOR_SPEED);
      if (rest.empty()) rest = shortest_chain(survey, mode.gives, -1);
      if (rest.empty()) continue;
      chain.insert(chain.end(), rest.begin(), rest.end());
    }
    entries.push_back(std::move(chain));
  }
  const auto level = [&](const std::vector<int>& chain) {
    return survey.modes[static_cast<std::size_t>(chain.front())].takes.signal;
  };
  std::stable_sort(entries.begin(), entries.end(),
                   [&](const auto& a, const auto& b) { return level(a) < level(b); });
  return entries;
}

std::string modes_table(const ControllerSurvey& survey) {
  TextTable table({"enters at", "drives", "actions -1..+1", "controllers"});
  for (const std::vector<int>& chain : entries_of(survey)) {
    const ControllerMode& first = survey.modes[static_cast<std::size_t>(chain.front())];
    const ControllerMode& last = survey.modes[static_cast<std::size_t>(chain.back())];
    table.add({with_size(first.takes.signal, first.takes.count), signal_name(last.gives.signal),
               ranges_text(first.low, first.high), chain_yaml(survey, chain)});
  }
  return table.to_string();
}

std::string refused_text(const ControllerSurvey& survey) {
  std::string text;
  for (const RefusedController& refused : survey.refused) {
    text += "  " + refused.plugin + ": " + refused.reason + "\n";
  }
  return text;
}

/// "robot quad" or "team pair of quad0, quad1".
std::string owner_of(const CompiledScenario& compiled, const ControllerChain& chain) {
  const Scenario& scenario = compiled.scenario();
  const auto robot = [&](int r) { return scenario.robots[static_cast<std::size_t>(r)].name; };
  if (chain.team < 0) return "robot " + robot(chain.robot);
  const TeamUse& team = scenario.teams[static_cast<std::size_t>(chain.team)];
  std::vector<std::string> names;
  for (const int r : team.robots) names.push_back(robot(r));
  return "team " + team.name + " of " + join(names);
}

std::string chain_heading(const CompiledScenario& compiled, const ControllerChain& chain) {
  const std::string level = with_size(chain.signal, chain.inputs);
  std::string entry = "actions are " + level;
  if (chain.signal == SKYBODY_NONE) entry = "takes no actions";
  if (chain.is_fed) entry = "a team's chain gives its " + level;
  return owner_of(compiled, chain) + ": " + entry + "\n";
}

/// A controller's outputs, and their receivers where they are not obvious.
std::string gives_text(const CompiledScenario& compiled, const PluginInstance& controller) {
  std::vector<std::string> parts;
  for (const PluginOutput& output : controller.controller.outputs) {
    const std::string robot =
        compiled.scenario().robots[static_cast<std::size_t>(output.robot)].name;
    parts.push_back(with_size(output.signal, output.count) +
                    (controller.controller.outputs.size() > 1 ? " to " + robot : ""));
  }
  return join(parts);
}

template <class Visit>
void each_controller(const CompiledScenario& compiled, const ControllerChain& chain, Visit visit) {
  for (int i = chain.first; i < chain.first + chain.count; ++i) {
    visit(compiled.plugins(SKYBODY_CONTROLLER)[static_cast<std::size_t>(i)]);
  }
}

std::string chain_table(const CompiledScenario& compiled, const ControllerChain& chain) {
  TextTable table({"level", "controller", "plugin", "gives", "actions -1..+1", "values"});
  each_controller(compiled, chain, [&](const PluginInstance& c) {
    table.add({with_size(c.controller.input_signal, c.controller.input_count()), c.name, c.plugin,
               gives_text(compiled, c), ranges_text(c.controller.low, c.controller.high),
               signal_meaning(c.controller.input_signal)});
  });
  return table.to_string();
}

JsonObject mode_json(const ControllerMode& mode) {
  JsonObject object;
  object.set_text("plugin", mode.plugin)
      .set("options", texts_json(mode.options))
      .set("takes", level_json(mode.takes.signal, mode.takes.count).text())
      .set("gives", level_json(mode.gives.signal, mode.gives.count).text())
      .set("passes_on", mode.passes_on ? "true" : "false")
      .set("low", numbers_json(mode.low))
      .set("high", numbers_json(mode.high))
      .set_text("doc", mode.doc);
  return object;
}

std::string refused_json(const ControllerSurvey& survey) {
  std::vector<std::string> all;
  for (const RefusedController& refused : survey.refused) {
    JsonObject object;
    object.set_text("plugin", refused.plugin).set_text("reason", refused.reason);
    all.push_back(object.text());
  }
  return json_array(all);
}

std::string chain_json(const CompiledScenario& compiled, const ControllerChain& chain) {
  std::vector<std::string> levels;
  each_controller(compiled, chain, [&](const PluginInstance& c) {
    std::vector<std::string> outputs;
    for (const PluginOutput& output : c.controller.outputs) {
      JsonObject given = level_json(output.signal, output.count);
      given.set_text("robot",
                     compiled.scenario().robots[static_cast<std::size_t>(output.robot)].name);
      outputs.push_back(given.text());
    }
    JsonObject level = level_json(c.controller.input_signal, c.controller.input_count());
    level.set_text("meaning", signal_meaning(c.controller.input_signal))
        .set_text("controller", c.name)
        .set_text("plugin", c.plugin)
        .set("gives", json_array(outputs))
        .set("low", numbers_json(c.controller.low))
        .set("high", numbers_json(c.controller.high));
    levels.push_back(level.text());
  });
  JsonObject object;
  object.set_text("of", owner_of(compiled, chain))
      .set("is_fed", chain.is_fed ? "true" : "false")
      .set("levels", json_array(levels));
  return object.text();
}

std::string robot_json(const RobotModes& robot) {
  std::vector<std::string> modes;
  for (const std::vector<int>& chain : entries_of(robot.survey)) {
    const ControllerMode& first = robot.survey.modes[static_cast<std::size_t>(chain.front())];
    const ControllerMode& last = robot.survey.modes[static_cast<std::size_t>(chain.back())];
    JsonObject mode = level_json(first.takes.signal, first.takes.count);
    mode.set_text("drives", signal_name(last.gives.signal))
        .set_text("controllers", chain_yaml(robot.survey, chain))
        .set("low", numbers_json(first.low))
        .set("high", numbers_json(first.high));
    modes.push_back(mode.text());
  }
  JsonObject object;
  object.set_text("robot", robot.robot)
      .set("modes", json_array(modes))
      .set("refused", refused_json(robot.survey));
  return object.text();
}

/// The modes of robots with equal modes, and the reasons why other controllers do not suit the
/// first of them.
std::string modes_text(const RobotModes& robot, const std::vector<std::string>& alike,
                       const std::string& table) {
  const std::string refused = refused_text(robot.survey);
  return "\nmodes of " + join(alike) + ", as a list for `robots." + robot.robot +
         ".controllers`\n" + table +
         (refused.empty() ? "" : "not possible for " + robot.robot + ":\n" + refused);
}

}  // namespace

std::string survey_text(const ControllerSurvey& survey) {
  TextTable table({"controller", "takes", "gives", "actions -1..+1", "with"});
  for (const ControllerMode& mode : survey.modes) {
    table.add({mode.plugin, mode.passes_on ? "any" : with_size(mode.takes.signal, mode.takes.count),
               mode.passes_on ? "the same" : with_size(mode.gives.signal, mode.gives.count),
               mode.passes_on ? "ranges of the next controller" : ranges_text(mode.low, mode.high),
               join(mode.options)});
  }
  std::string text = signal_table() + "\n" + table.to_string();
  const std::string refused = refused_text(survey);
  return refused.empty() ? text : text + "\ncontrollers with required parameters:\n" + refused;
}

std::string survey_json(const ControllerSurvey& survey) {
  std::vector<std::string> signals, modes;
  for (int signal = 0; signal < SKYBODY_SIGNAL_COUNT; ++signal) {
    JsonObject object;
    object.set_text("signal", signal_name(signal))
        .set_text("meaning", signal_meaning(signal))
        .set("acts", actuates(signal) ? "true" : "false");
    signals.push_back(object.text());
  }
  for (const ControllerMode& mode : survey.modes) modes.push_back(mode_json(mode).text());
  JsonObject object;
  object.set("signals", json_array(signals))
      .set("controllers", json_array(modes))
      .set("refused", refused_json(survey));
  return json_indented(object.text()) + "\n";
}

std::string chains_text(const CompiledScenario& compiled, const std::vector<RobotModes>& robots) {
  std::string text;
  for (const ControllerChain& chain : compiled.chains()) {
    text +=
        (text.empty() ? "" : "\n") + chain_heading(compiled, chain) + chain_table(compiled, chain);
  }
  if (text.empty()) text = "no robot has controllers, so there are no actions for a policy\n";
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const std::string table = modes_table(robots[i].survey);
    std::vector<std::string> alike;
    bool is_new = true;
    for (std::size_t k = 0; k < robots.size(); ++k) {
      if (modes_table(robots[k].survey) != table) continue;
      alike.push_back(robots[k].robot);
      is_new = is_new && k >= i;
    }
    if (is_new) text += modes_text(robots[i], alike, table);
  }
  return text;
}

std::string chains_json(const CompiledScenario& compiled, const std::vector<RobotModes>& robots) {
  std::vector<std::string> chains, modes;
  for (const ControllerChain& chain : compiled.chains()) {
    chains.push_back(chain_json(compiled, chain));
  }
  for (const RobotModes& robot : robots) modes.push_back(robot_json(robot));
  JsonObject object;
  object.set_text("scenario", compiled.scenario().name)
      .set("chains", json_array(chains))
      .set("robots", json_array(modes));
  return json_indented(object.text()) + "\n";
}

}  // namespace skybody
