#include "core/env/param_access.h"

#include <algorithm>
#include <set>
#include <sstream>

#include "core/base/system/error.h"
#include "core/base/system/suggestion.h"
#include "core/plugin_abi/path_pattern.h"

namespace skybody {
namespace {

/// The path without the index at its end, if there is one.
std::string stem_of(const std::string& path) {
  return path.empty() || path.back() != ']' ? path : path.substr(0, path.rfind('['));
}

int index_of(const CompiledScenario& compiled, const std::string& path) {
  const StateLayout& layout = compiled.layout();
  const int index = layout.find_param(path);
  if (index >= 0) return index;
  if (layout.find_param(path + "[0]") >= 0) {
    throw Error("`" + path + "` is a vector: name one of its values, such as `" + path + "[0]`");
  }
  throw Error("nothing randomizable is called `" + path + "`" + nearest_param(layout, path));
}

}  // namespace

std::string nearest_param(const StateLayout& layout, const std::string& path) {
  const bool is_indexed = path.find('[') != path.npos;
  std::set<std::string> names;
  for (const EnvParam& param : layout.param_info) {
    names.insert(is_indexed ? param.path : stem_of(param.path));
    if (!param.alias.empty()) names.insert(is_indexed ? param.alias : stem_of(param.alias));
  }
  const std::string found = closest(path, {names.begin(), names.end()});
  const std::string where = plugin_detail::kNoSuchParam;
  return found.empty() ? where : "; did you mean `" + found + "`? " + where.substr(2);
}

std::vector<int> find_params(const Scenario& scenario, const StateLayout& layout,
                             const std::string& path) {
  std::vector<std::string> robots;
  for (const RobotUse& robot : scenario.robots) robots.push_back(robot.name);
  const auto patterns = plugin_detail::patterns_of(path, robots);
  std::vector<int> found;
  for (std::size_t k = 0; k < layout.param_info.size(); ++k) {
    const EnvParam& param = layout.param_info[k];
    if (plugin_detail::any_matches(patterns, param.path, param.alias)) {
      found.push_back(static_cast<int>(k));
    }
  }
  if (found.empty()) {
    throw Error("nothing randomizable is called `" + path + "`" + nearest_param(layout, path));
  }
  return found;
}

void check_vector_size(const Scenario& scenario, const StateLayout& layout, const std::string& path,
                       std::size_t count) {
  const std::vector<int> found = find_params(scenario, layout, path);
  const auto name = [&](int k) { return layout.param_info[static_cast<std::size_t>(k)].path; };
  const bool is_indexed = !path.empty() && path.back() == ']';
  for (std::size_t i = 0; i < found.size();) {
    const bool is_one = is_indexed || name(found[i]).back() != ']';
    const std::string vector = stem_of(name(found[i]));
    std::size_t size = 1;
    while (!is_one && i + size < found.size() && stem_of(name(found[i + size])) == vector) ++size;
    if (is_one) {
      throw Error("`" + name(found[i]) + "` is one number, and a list of " + std::to_string(count) +
                  " is given: give a number");
    }
    if (size != count) {
      throw Error("`" + vector + "` has " + std::to_string(size) + " values, and " +
                  std::to_string(count) + (count == 1 ? " is" : " are") + " given: give all " +
                  std::to_string(size));
    }
    i += size;
  }
}

void check_one_value(const Scenario& scenario, const StateLayout& layout, const std::string& path) {
  const std::vector<int> found = find_params(scenario, layout, path);
  if (path.back() == ']' || path.back() == '*') return;  // names each value
  for (const int k : found) {
    const std::string& name = layout.param_info[static_cast<std::size_t>(k)].path;
    if (name.back() != ']') continue;
    const std::string vector = stem_of(name);
    const auto size = std::count_if(found.begin(), found.end(), [&](int other) {
      return stem_of(layout.param_info[static_cast<std::size_t>(other)].path) == vector;
    });
    throw Error("`" + vector + "` has " + std::to_string(size) +
                " values, and one number is given: give all " + std::to_string(size) +
                ", or name one of them, such as `" + name + "`");
  }
}

double get_param(const CompiledScenario& compiled, const StateGroup& group, int lane,
                 const std::string& path) {
  const int index = index_of(compiled, path);
  return group.reals(compiled.layout().params.offset + index)[lane];
}

void set_param(const CompiledScenario& compiled, StateGroup& group, int lane,
               const std::string& path, double value) {
  const int index = index_of(compiled, path);
  const EnvParam& info = compiled.layout().param_info[static_cast<std::size_t>(index)];
  if (!(value >= info.min && value <= info.max)) {
    std::ostringstream message;
    message << path << " = " << value << " is outside [" << info.min << ", " << info.max << "] "
            << info.unit;
    throw Error(message.str());
  }
  group.writable({compiled.layout().params.offset + index, 1}, 1u << lane)[lane] = value;
}

}  // namespace skybody
