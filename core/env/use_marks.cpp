#include "core/env/use_marks.h"

#include <algorithm>
#include <vector>

#include "core/env/param_access.h"
#include "plugins/api/path_pattern.h"

namespace skybody {
namespace {

/// The words of a message that stand in backticks.
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

}  // namespace

SourceMark blamed(const PluginUse& use, const std::string& message) {
  const std::vector<std::string> words = quoted_words(message);
  for (const std::string& word : words) {
    for (const ParameterValue& value : use.parameters) {
      if (value.name == word.substr(0, word.find('['))) return value.mark;
    }
  }
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

std::string with_nearest_param(const Layout& layout, const std::string& message) {
  const std::size_t end = message.rfind(plugin_detail::kNoSuchParam);
  const std::vector<std::string> words = quoted_words(message.substr(0, end));
  if (end == std::string::npos || words.empty()) return message;
  return message.substr(0, end) + nearest_param(layout, words.back());
}

SourceMark mark_of_writer(const Scenario& scenario, const PluginUse& use, const EnvParam& param) {
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
