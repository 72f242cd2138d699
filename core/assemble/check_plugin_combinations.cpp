#include "core/assemble/check_plugin_combinations.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/model/located_error.h"

namespace skybody {
namespace {

/// A parameter's value or default; null if a user's plugin of the same name lacks the parameter.
const ParameterValue* parameter_of(const PluginUse& use, const std::string& name) {
  const auto found = std::find_if(use.parameters.begin(), use.parameters.end(),
                                  [&](const ParameterValue& value) { return value.name == name; });
  return found == use.parameters.end() ? nullptr : &*found;
}

/// Whether a list of robot names includes this robot; an empty list includes all.
bool means(const ParameterValue& names, const std::string& robot) {
  const std::vector<std::string>& texts = names.texts;
  const bool is_empty = texts.empty() || (texts.size() == 1 && texts[0].empty());
  return is_empty || std::find(texts.begin(), texts.end(), robot) != texts.end();
}

std::string place_of(const SourceLocation& mark) {
  return mark.line > 0 ? "line " + std::to_string(mark.line) : mark.file;
}

/// Whether a parameter affects the robot's hover speed: gravity, masses, and the rotors' constants.
bool matters_for_hover(const CompiledScenario& compiled, std::size_t robot, int param) {
  const StateLayout& l = compiled.layout();
  const auto k = [](int i) { return static_cast<std::size_t>(i); };
  if (l.param_info[k(param)].path.rfind("gravity[", 0) == 0) return true;
  const RobotLayout& of = l.robots[robot];
  for (int b = of.first_body; b < of.first_body + of.body_count; ++b) {
    if (param == l.body_params[k(b)] + kMass) return true;
  }
  for (int r = of.first_rotor; r < of.first_rotor + of.rotor_count; ++r) {
    const int first = l.rotor_params[k(r)];
    if (param == first + kThrustConstant || param == first + kMaxSpeed) return true;
  }
  return false;
}

/// `start` reads the current parameters: values drawn later are still those of the last episode.
void check_hover_speeds(const CompiledScenario& compiled, std::size_t place) {
  const Scenario& scenario = compiled.scenario();
  const PluginUse& start = scenario.randomization[place];
  const ParameterValue* const speed = parameter_of(start, "rotor_speed");
  const ParameterValue* const robots = parameter_of(start, "robot");
  if (speed == nullptr || robots == nullptr || speed->texts != std::vector<std::string>{"hover"}) {
    return;
  }
  for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
    if (!means(*robots, scenario.robots[r].name)) continue;
    for (std::size_t i = place + 1; i < scenario.randomization.size(); ++i) {
      const PluginInstance& other = compiled.plugins(SKYBODY_RANDOMIZER)[i];
      for (const int param : other.writes) {
        if (!matters_for_hover(compiled, r, param)) continue;
        throw LocatedError(
            speed->mark,
            "`rotor_speed: hover` takes what carries the drawn weight, but randomizer `" +
                other.name + "` (" + place_of(other.mark) + ") draws " +
                compiled.layout().param_info[static_cast<std::size_t>(param)].path + " after `" +
                start.instance + "`, which would take the last episode's: put `" + start.instance +
                "` behind it");
      }
    }
  }
}

/// Effects allowed once per robot: two of them would contradict each other.
struct Single {
  const char* plugin;
  const char* thing;
};
constexpr Single kSingles[] = {{"battery", "a battery"}, {"motor", "motors"}};

bool serves(const CompiledScenario& compiled, const PluginUse& use, std::size_t robot) {
  const ParameterValue* const names = parameter_of(use, "robots");
  return names != nullptr && compiled.layout().robots[robot].rotor_count > 0 &&
         means(*names, compiled.scenario().robots[robot].name);
}

void check_single(const CompiledScenario& compiled, const Single& single) {
  const Scenario& scenario = compiled.scenario();
  for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
    const PluginUse* first = nullptr;
    for (const PluginUse& use : scenario.effects) {
      if (use.plugin != single.plugin || !serves(compiled, use, r)) continue;
      if (first != nullptr) {
        throw LocatedError(
            use.mark, "robot `" + scenario.robots[r].name + "` has " + single.thing +
                          " already, from `" + first->instance + "` (" + place_of(first->mark) +
                          "): leave one of the two out, or give each other `robots`");
      }
      first = &use;
    }
  }
}

}  // namespace

void check_plugin_combinations(const CompiledScenario& compiled) {
  const std::vector<PluginUse>& randomizers = compiled.scenario().randomization;
  for (std::size_t i = 0; i < randomizers.size(); ++i) {
    if (randomizers[i].plugin == "start") check_hover_speeds(compiled, i);
  }
  for (const Single& single : kSingles) check_single(compiled, single);
}

}  // namespace skybody
