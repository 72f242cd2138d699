#include "tests/unit/onboard/hover_mission.h"

#include <string>

#include "core/base/constants.h"
#include "onboard/situation.h"
#include "onboard/task_host.h"

namespace skybody::onboard {
namespace {

/// Default values of a task's parameters. Randomizable ones are the world's only parameters.
std::vector<SetupValue> defaults_of(const SkybodyPlugin& task,
                                    std::vector<SkybodyEnvParamInfo>& params,
                                    std::deque<std::string>& names) {
  std::vector<SetupValue> values;
  for (std::uint32_t k = 0; k < task.parameter_count; ++k) {
    const SkybodyParameter& p = task.parameters[k];
    SetupValue value;
    value.name = p.name;
    if (p.type == SKYBODY_TEXT) {
      value.texts.assign(p.default_texts, p.default_texts + p.default_count);
    } else {
      value.numbers.assign(p.default_numbers, p.default_numbers + p.default_count);
    }
    if (p.randomizable == 1) {
      value.env_param = static_cast<std::int32_t>(params.size());
      for (std::size_t i = 0; i < value.numbers.size(); ++i) {
        names.push_back("task." + value.name + "[" + std::to_string(i) + "]");
        params.push_back({names.back().c_str(), "", value.numbers[i], -100.0, 100.0});
      }
    }
    values.push_back(value);
  }
  return values;
}

SkybodyRotorInfo rotor(int index) {
  SkybodyRotorInfo r{};
  r.name = "rotor";
  r.axis[2] = r.axis_in_base[2] = 1.0;
  r.direction = index % 2 == 0 ? 1.0 : -1.0;
  r.constants[SKYBODY_ROTOR_THRUST_CONSTANT] = kMostThrust / 4e6;
  r.constants[SKYBODY_ROTOR_MAX_SPEED] = 1000.0;
  return r;
}

/// A network without weights, whose outputs are its biases.
PolicyFile constant_policy(int observations, int actions) {
  PolicyFile policy;
  policy.observation_size = observations;
  policy.action_size = actions;
  PolicyLayer layer;
  layer.inputs = observations;
  layer.outputs = actions;
  layer.weight.assign(static_cast<std::size_t>(observations * actions), 0.0);
  layer.bias.assign(static_cast<std::size_t>(actions), kHoverAction);
  policy.layers.push_back(layer);
  return policy;
}

}  // namespace

Motion level_at(double x, double y, double z) {
  Motion motion;
  motion.position = {x, y, z};
  return motion;
}

Mission hover_mission(int signal) {
  constexpr int kObservations = 22;  // of `hover` with four actions
  std::vector<SkybodyEnvParamInfo> params;
  std::deque<std::string> names;
  SkybodyRobotInfo robot{};
  robot.name = "quad";
  robot.body_count = 1;
  robot.rotor_count = 4;
  robot.q_count = 7;
  robot.u_count = 6;
  robot.rotation[0] = 1.0;
  robot.action_count = 4;
  robot.chain_count = 1;
  SkybodyBodyInfo body{};
  body.name = "base";
  body.joint_name = "";
  body.parent = -1;
  body.mass = kMass;
  body.joint = SKYBODY_FREE;
  const SkybodyRotorInfo rotors[] = {rotor(0), rotor(1), rotor(2), rotor(3)};
  const SkybodyChainInfo chain{0, signal, 0, 4};
  std::vector<SetupValue> values = defaults_of(*find_task("hover"), params, names);
  const SkybodySensorInfo sensors[] = {{"imu", "specific_force", 0, 3},
                                       {"imu", "angular_rate", 3, 3}};
  SkybodySetup s{};
  s.sensors = sensors;
  s.sensor_count = 2;
  s.instance = "task";
  s.dt = 0.005;
  s.action_repeat = 2;
  s.gravity[2] = -9.8;
  s.robots = &robot;
  s.robot_count = 1;
  s.bodies = &body;
  s.body_count = 1;
  s.rotors = rotors;
  s.rotor_count = 4;
  s.chains = &chain;
  s.chain_count = 1;
  s.params = params.data();
  s.param_count = static_cast<std::int32_t>(params.size());
  Mission mission;
  mission.scenario = "hover_test";
  mission.task = "hover";
  mission.task_version = find_task("hover")->version;
  mission.setup = SetupCopy(s, std::move(values));
  mission.columns = {{"position_error", "m", "", 0, 3}};
  mission.actions = {{"ctbr", 0, 0, {0.0, -2.0, -2.0, -2.0}, {kMostThrust, 2.0, 2.0, 2.0}}};
  mission.policy = constant_policy(kObservations, 4);
  return mission;
}

}  // namespace skybody::onboard
