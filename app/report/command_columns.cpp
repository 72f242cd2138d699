#include "app/report/command_columns.h"

#include "core/env/plugin_setup_tables.h"

namespace skybody {
namespace {

/// Components of a signal in order: for a wrench those of one site, for a trajectory those of one
/// point. An attitude may lack the last three, a force the last one.
std::vector<LogColumn> fixed_columns(int signal) {
  switch (signal) {
    case SKYBODY_CTBT:
      return {{"thrust", "N"}, {"torque_x", "N m"}, {"torque_y", "N m"}, {"torque_z", "N m"}};
    case SKYBODY_CTBR:
      return {{"thrust", "N"}, {"rate_x", "rad/s"}, {"rate_y", "rad/s"}, {"rate_z", "rad/s"}};
    case SKYBODY_WRENCH:
      return {{"force_x", "N"},    {"force_y", "N"},    {"force_z", "N"},
              {"moment_x", "N m"}, {"moment_y", "N m"}, {"moment_z", "N m"}};
    case SKYBODY_VELOCITY:
      return {{"v_x", "m/s"},   {"v_y", "m/s"},   {"v_z", "m/s"},
              {"w_x", "rad/s"}, {"w_y", "rad/s"}, {"w_z", "rad/s"}};
    case SKYBODY_POSE:
      return {{"x", "m"}, {"y", "m"}, {"z", "m"}, {"qw", ""}, {"qx", ""}, {"qy", ""}, {"qz", ""}};
    case SKYBODY_ATTITUDE:
      return {{"thrust", "N"}, {"qw", ""},          {"qx", ""},          {"qy", ""},
              {"qz", ""},      {"rate_x", "rad/s"}, {"rate_y", "rad/s"}, {"rate_z", "rad/s"}};
    case SKYBODY_POSITION:
      return {{"x", "m"}, {"y", "m"}, {"z", "m"}, {"yaw", "rad"}};
    case SKYBODY_TRAJECTORY:
      return {{"x", "m"},           {"y", "m"},       {"z", "m"},       {"v_x", "m/s"},
              {"v_y", "m/s"},       {"v_z", "m/s"},   {"a_x", "m/s^2"}, {"a_y", "m/s^2"},
              {"a_z", "m/s^2"},     {"j_x", "m/s^3"}, {"j_y", "m/s^3"}, {"j_z", "m/s^3"},
              {"s_x", "m/s^4"},     {"s_y", "m/s^4"}, {"s_z", "m/s^4"}, {"yaw", "rad"},
              {"yaw_rate", "rad/s"}};
    case SKYBODY_FORCE:
      return {{"force_x", "N"}, {"force_y", "N"}, {"force_z", "N"}, {"yaw", "rad"}};
    case SKYBODY_ACCELERATION:
      return {{"a_x", "m/s^2"}, {"a_y", "m/s^2"}, {"a_z", "m/s^2"}, {"yaw", "rad"}};
    case SKYBODY_VELOCITY_TRACKING:
      return {{"v_x", "m/s"}, {"v_y", "m/s"}, {"v_z", "m/s"}, {"yaw_rate", "rad/s"}};
    default:
      return {};
  }
}

/// One component per rotor of the robot.
std::vector<LogColumn> rotor_columns(const RobotModel& model, int signal) {
  const LogColumn column = signal == SKYBODY_ROTOR_SPEED ? LogColumn{".speed", "rad/s"}
                           : signal == SKYBODY_SRT       ? LogColumn{".thrust", "N"}
                                                         : LogColumn{".throttle", ""};
  std::vector<LogColumn> columns;
  for (const Rotor& rotor : model.rotors) {
    columns.push_back({rotor.name + column.name, column.unit});
  }
  return columns;
}

}  // namespace

std::vector<LogColumn> command_columns(const CompiledScenario& compiled,
                                       const ControllerChain& chain) {
  const int signal = chain.signal;
  const RobotUse& robot = compiled.scenario().robots.at(static_cast<std::size_t>(chain.robot));
  std::vector<LogColumn> one = fixed_columns(signal);
  const bool is_of_rotors =
      signal == SKYBODY_ROTOR_SPEED || signal == SKYBODY_SRT || signal == SKYBODY_THROTTLE;
  if (is_of_rotors && chain.team < 0) {
    one = rotor_columns(robot.model, signal);
  }
  const std::string& owner =
      chain.team < 0 ? robot.name
                     : compiled.scenario().teams[static_cast<std::size_t>(chain.team)].name;
  const auto count = static_cast<std::size_t>(chain.inputs);
  std::vector<LogColumn> columns;
  for (std::size_t k = 0; k < count; ++k) {
    LogColumn column = one.empty() ? LogColumn{signal_name(signal), ""} : one[k % one.size()];
    if (one.size() < count)
      column.name += "[" + std::to_string(one.empty() ? k : k / one.size()) + "]";
    columns.push_back({owner + "." + column.name, column.unit});
  }
  return columns;
}

std::vector<std::string> action_names(const CompiledScenario& compiled) {
  std::vector<std::string> names;
  if (compiled.task().task.actions.empty()) {
    for (const ControllerChain& chain : compiled.chains()) {
      if (chain.is_fed) continue;
      for (const LogColumn& column : command_columns(compiled, chain)) {
        names.push_back(column.name);
      }
    }
    return names;
  }
  for (const ActionChannel& channel : compiled.action_channels()) {
    const std::size_t count = channel.low.size();
    const RobotUse& robot = compiled.scenario().robots[static_cast<std::size_t>(channel.robot)];
    for (std::size_t k = 0; k < count; ++k) {
      const std::string index = count == 1 ? "" : "[" + std::to_string(k) + "]";
      names.push_back(robot.name + "." + channel.name + index);
    }
  }
  return names;
}

}  // namespace skybody
