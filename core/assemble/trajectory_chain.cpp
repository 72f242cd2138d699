#include "core/assemble/trajectory_chain.h"

#include <algorithm>
#include <string>
#include <vector>

namespace skybody {
namespace {

constexpr const char* kTaskWithTrajectory = "trajectory";

/// @param use  a PluginUse, const or not. @returns its parameter, or null
template <class Use>
auto* parameter_of(Use& use, const std::string& parameter) {
  const auto found = std::find_if(use.parameters.begin(), use.parameters.end(),
                                  [&](const ParameterValue& v) { return v.name == parameter; });
  return found == use.parameters.end() ? nullptr : &*found;
}

bool is_left_open(const PluginUse& use, const char* plugin, const char* parameter) {
  if (use.plugin != plugin) return false;
  const ParameterValue* value = parameter_of(use, parameter);
  return value != nullptr && !value->is_given;
}

/// The robot of the task, or null.
RobotUse* robot_of_task(Scenario& scenario) {
  const ParameterValue* robot = parameter_of(scenario.task, "robot");
  const std::string name = robot == nullptr || robot->texts.empty() ? "" : robot->texts[0];
  if (name.empty()) return scenario.robots.size() == 1 ? &scenario.robots[0] : nullptr;
  const auto found = std::find_if(scenario.robots.begin(), scenario.robots.end(),
                                  [&](const RobotUse& r) { return r.name == name; });
  return found == scenario.robots.end() ? nullptr : &*found;
}

}  // namespace

const PluginUse& first_controller(const CompiledScenario& compiled, const ControllerChain& chain) {
  const std::vector<RobotUse>& robots = compiled.scenario().robots;
  const auto robot = static_cast<std::size_t>(chain.robot);
  std::size_t place = static_cast<std::size_t>(chain.first);
  for (std::size_t r = 0; r < robot; ++r) place -= robots[r].controllers.size();
  return robots[robot].controllers[place];
}

TrajectoryChain open_trajectory_chain(const PluginUse* chain, int count) {
  const bool begins = is_left_open(chain[0], "position", "signal");
  if (begins && count > 1 && is_left_open(chain[1], "attitude", "feed_forward")) {
    return {true, true};
  }
  return {false, is_left_open(chain[0], "attitude", "feed_forward")};
}

double point_spacing(const PluginUse& law) {
  const ParameterValue* const step =
      law.plugin == "nmpc" ? parameter_of(law, "node_step") : nullptr;
  return step == nullptr ? 0.0 : step->numbers.at(0);
}

bool has_trajectory(const PluginUse& task) { return task.plugin == kTaskWithTrajectory; }

void take_trajectory_of_task(Scenario& scenario) {
  if (!has_trajectory(scenario.task)) return;
  RobotUse* const robot = robot_of_task(scenario);
  if (robot == nullptr || robot->controllers.empty()) return;
  std::vector<PluginUse>& chain = robot->controllers;
  if (!open_trajectory_chain(chain.data(), static_cast<int>(chain.size())).position) return;
  // These values are still defaults that depend on the task: `is_given` stays false.
  parameter_of(chain[0], "signal")->texts = {"trajectory"};
  parameter_of(chain[1], "feed_forward")->numbers = {1.0};
}

}  // namespace skybody
