#include "core/env/error_location.h"

#include <algorithm>
#include <vector>

#include "core/env/param_access.h"
#include "core/plugin_abi/path_pattern.h"

namespace skybody {
namespace {

/// The words in backticks of a message.
std::vector<std::string> quoted_words(const std::string& message) {
  std::vector<std::string> words;
  for (std::size_t from = message.find('`'); from != std::string::npos;) {
    const std::size_t to = message.find('`', from + 1);
    if (to == std::string::npos) break;
    words.push_back(message.substr(from + 1, to - from - 1));
    from = message.find('`', to + 1);
  }
  return words;
}

/// An item of the scenario that a message names.
struct Named {
  SourceLocation mark;
  bool is_given = true;  ///< false: a parameter's default
};

/// The parameter named by a word such as `range`, `range[1]` or `kind: hold`, or null.
const ParameterValue* parameter_of(const PluginUse& use, const std::string& word) {
  const std::string name = word.substr(0, word.find_first_of("[:"));
  for (const ParameterValue& value : use.parameters) {
    if (value.name == name) return &value;
  }
  return nullptr;
}

/// The obstacle of that name, or null.
const Obstacle* obstacle_of(const Scenario& scenario, const std::string& word) {
  for (const Obstacle& obstacle : scenario.obstacles) {
    if (obstacle.name == word) return &obstacle;
  }
  return nullptr;
}

/// The items that the words name, in order: parameters, and obstacles if the message begins with
/// one.
std::vector<Named> named_by(const std::vector<std::string>& words, const Scenario& scenario,
                            const PluginUse& use) {
  std::vector<Named> all;
  const bool has_obstacles = !words.empty() && parameter_of(use, words[0]) == nullptr &&
                             obstacle_of(scenario, words[0]) != nullptr;
  for (const std::string& word : words) {
    if (const ParameterValue* value = parameter_of(use, word)) {
      all.push_back({value->mark, value->is_given});
    } else if (const Obstacle* obstacle = obstacle_of(scenario, word); has_obstacles && obstacle) {
      all.push_back({obstacle->mark});
    }
  }
  return all;
}

}  // namespace

bool is_own(const Scenario& scenario, const SourceLocation& mark) {
  return mark.line == 0 || mark.file == scenario.file;
}

SourceLocation blamed(const Scenario& scenario, const PluginUse& use, const std::string& message) {
  const std::vector<std::string> words = quoted_words(message);
  const std::vector<Named> all = named_by(words, scenario, use);
  for (const Named& named : all) {
    if (named.is_given && is_own(scenario, named.mark)) return named.mark;
  }
  if (!all.empty()) return all.front().mark;
  for (const std::string& word : words) {
    for (const ParameterValue& value : use.parameters) {
      const auto& texts = value.texts;
      if (value.is_given && std::find(texts.begin(), texts.end(), word) != texts.end()) {
        return value.mark;
      }
    }
  }
  return use.mark;
}

std::string with_nearest_param(const StateLayout& layout, const std::string& message) {
  const std::size_t end = message.rfind(plugin_detail::kNoSuchParam);
  const std::vector<std::string> words = quoted_words(message.substr(0, end));
  if (end == std::string::npos || words.empty()) return message;
  return message.substr(0, end) + nearest_param(layout, words.back());
}

SourceLocation mark_of_writer(const Scenario& scenario, const PluginUse& use,
                              const EnvParam& param) {
  std::vector<std::string> robots;
  for (const RobotUse& robot : scenario.robots) robots.push_back(robot.name);
  for (const ParameterValue& value : use.parameters) {
    if (!value.is_given) continue;
    for (const std::string& text : value.texts) {
      const auto patterns = plugin_detail::patterns_of(text, robots);
      if (plugin_detail::any_matches(patterns, param.path, param.alias)) return value.mark;
    }
  }
  return use.mark;
}

}  // namespace skybody
