#include "core/env/param_access.h"

#include <sstream>

#include "core/base/error.h"
#include "plugins/api/path_pattern.h"

namespace skybody {
namespace {

int index_of(const CompiledScenario& compiled, const std::string& path) {
  const int index = compiled.layout().find_param(path);
  if (index < 0) {
    throw Error("nothing randomizable is called `" + path +
                "`; `skybody check --parameters` lists what is");
  }
  return index;
}

}  // namespace

std::vector<int> find_params(const Scenario& scenario, const Layout& layout,
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
    throw Error("nothing randomizable is called `" + path + "`" + plugin_detail::kNoSuchParam);
  }
  return found;
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
