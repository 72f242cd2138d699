#include "app/report/flight_record.h"

#include <skybody/build_info.h>
#include <skybody/git_describe.h>

#include <cstring>

#include "app/report/command_columns.h"
#include "app/report/reference_errors.h"
#include "core/io/files/file.h"
#include "core/version.h"

namespace skybody {
namespace {

/// Names of a joint's coordinates; M in F, see robot_model.h.
std::vector<LogColumn> position_columns(JointType type) {
  switch (type) {
    case JointType::kFree:
      return {{"x", "m"}, {"y", "m"}, {"z", "m"}, {"qw", ""}, {"qx", ""}, {"qy", ""}, {"qz", ""}};
    case JointType::kBall:
      return {{"qw", ""}, {"qx", ""}, {"qy", ""}, {"qz", ""}};
    case JointType::kPin:
      return {{"angle", "rad"}};
    case JointType::kSlider:
      return {{"travel", "m"}};
    case JointType::kUniversal:
      return {{"angle_x", "rad"}, {"angle_y", "rad"}};
    case JointType::kWeld:
      return {};
  }
  return {};
}

std::vector<LogColumn> velocity_columns(JointType type) {
  switch (type) {
    case JointType::kFree:
      return {{"vx", "m/s"},   {"vy", "m/s"},   {"vz", "m/s"},
              {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}};
    case JointType::kBall:
      return {{"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}};
    case JointType::kPin:
      return {{"rate", "rad/s"}};
    case JointType::kSlider:
      return {{"rate", "m/s"}};
    case JointType::kUniversal:
      return {{"rate_x", "rad/s"}, {"rate_y", "rad/s"}};
    case JointType::kWeld:
      return {};
  }
  return {};
}

void append(std::vector<LogColumn>& columns, const std::string& prefix,
            const std::vector<LogColumn>& more) {
  for (const LogColumn& column : more) columns.push_back({prefix + "." + column.name, column.unit});
}

/// `name` for a single value, `name[0]`, `name[1]`, ... for several.
void append(std::vector<LogColumn>& columns, const std::string& name, const std::string& unit,
            int count) {
  for (int k = 0; k < count; ++k) {
    const std::string index = count == 1 ? "" : "[" + std::to_string(k) + "]";
    columns.push_back({name + index, unit});
  }
}

/// The columns of the row of observations, then those of the privileged row.
void describe_observation(const CompiledScenario& compiled, FlightLogHeader& header) {
  for (const bool privileged : {false, true}) {
    for (const ObservationColumn& column : compiled.columns()) {
      if (column.privileged != privileged || column.image >= 0) continue;
      append(header.observation, column.name, column.unit, column.count());
    }
  }
}

void describe_bodies(const CompiledScenario& compiled, FlightLogHeader& header) {
  const World& world = compiled.world();
  for (std::size_t k = 0; k < world.bodies.size(); ++k) {
    const std::string name = body_name(compiled, static_cast<int>(k));
    header.bodies.push_back(name);
    append(header.q, name, position_columns(world.bodies[k].model->joint.type));
    append(header.u, name, velocity_columns(world.bodies[k].model->joint.type));
  }
  for (const WorldRotor& rotor : world.rotors) {
    const RobotUse& robot = world.scenario.robots[static_cast<std::size_t>(rotor.robot)];
    header.rotors.push_back({robot.name + "." + rotor.model->name, "rad/s"});
  }
}

void describe_signals(const CompiledScenario& compiled, FlightLogHeader& header) {
  for (const ControllerChain& chain : compiled.chains()) {
    for (const LogColumn& column : command_columns(compiled, chain)) {
      header.command.push_back(column);
    }
  }
  for (const std::string& name : action_names(compiled)) header.action.push_back({name, ""});
  for (const PluginInstance& sensor : compiled.plugins(SKYBODY_SENSOR)) {
    for (const Channel& channel : sensor.channels) {
      if (channel.is_image()) continue;
      append(header.sensors, sensor.name + "." + channel.name, channel.unit, channel.count);
    }
  }
  describe_observation(compiled, header);
  for (const Channel& channel : compiled.info_channels())
    append(header.info, channel.name, channel.unit, channel.count);
  // Readers use a body's first goal: if it follows a reference, that is the goal.
  for (const FlownReference& reference : flown_references(compiled)) {
    header.goals.push_back(body_name(compiled, reference.body));
    header.references.push_back(reference.kind);
  }
  for (const Goal& goal : compiled.task().task.goals) {
    header.goals.push_back(body_name(compiled, goal.body));
  }
}

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"skybody", version()},
          {"git", SKYBODY_GIT_DESCRIBE},
          {"build", SKYBODY_BUILD_TYPE},
          {"sanitizers", SKYBODY_SANITIZE},
          {"compiler", SKYBODY_COMPILER},
          {"simbody", SKYBODY_SIMBODY_VERSION},
          {"libraries", SKYBODY_LIBRARY_VERSIONS}};
}

/// A block of state words as doubles.
std::vector<double> values_of(const Snapshot& snapshot, Block block) {
  std::vector<double> values(static_cast<std::size_t>(block.size));
  if (!values.empty()) {
    std::memcpy(values.data(), snapshot.words.data() + block.offset,
                values.size() * sizeof(double));
  }
  return values;
}

/// Whether there are contacts. After a fault they may not be computable.
bool touches_anything(const Simulation& simulation) {
  return !simulation.fault() && !simulation.contacts().empty();
}

}  // namespace

std::string body_name(const CompiledScenario& compiled, int body) {
  const WorldBody& b = compiled.world().bodies.at(static_cast<std::size_t>(body));
  return compiled.scenario().robots[static_cast<std::size_t>(b.robot)].name + "." + b.model->name;
}

FlightLogHeader describe_flight(const CompiledScenario& compiled, std::uint64_t seed,
                                const std::string& policy) {
  const Scenario& scenario = compiled.scenario();
  FlightLogHeader header;
  header.scenario_name = scenario.name;
  header.scenario_file = absolute_path(scenario.file);
  header.scenario_text = scenario.text;
  header.scenario_hash = scenario.hash;
  header.seed = seed;
  header.policy = policy;
  header.dt = scenario.stepping.dt;
  header.action_repeat = scenario.stepping.action_repeat;
  header.versions = versions();
  describe_bodies(compiled, header);
  describe_signals(compiled, header);
  for (const EnvParam& param : compiled.layout().param_info) {
    header.params.push_back({param.path, param.unit});
    header.nominal_params.push_back(param.nominal);
  }
  return header;
}

void record(const Simulation& simulation, FlightLog& log) {
  const StateLayout& layout = simulation.compiled().layout();
  const Snapshot state = simulation.save();
  const std::vector<double> q = values_of(state, layout.q), u = values_of(state, layout.u);
  const std::vector<double> speed = values_of(state, layout.rotor_speed);
  const std::vector<double> rotor_command = values_of(state, layout.rotor_command);
  const std::vector<double> action = values_of(state, layout.action);
  const std::vector<double> command = values_of(state, layout.command);
  const std::vector<double> sensors = values_of(state, layout.sensors);
  std::vector<double> goal = reference_places(simulation, flown_references(simulation.compiled()));
  const std::vector<double> of_task = simulation.goals();
  goal.insert(goal.end(), of_task.begin(), of_task.end());
  const std::span<const float> seen = simulation.observation(), more = simulation.privileged();
  std::vector<float> observation(seen.begin(), seen.end());
  observation.insert(observation.end(), more.begin(), more.end());
  const std::vector<BodyState>& bodies = simulation.bodies();
  FlightLogRow row;
  row.time = simulation.time();
  row.bodies = {reinterpret_cast<const double*>(bodies.data()),
                bodies.size() * sizeof(BodyState) / sizeof(double)};
  row.q = q;
  row.u = u;
  row.rotor_speed = speed;
  row.rotor_command = rotor_command;
  row.action = action;
  row.command = command;
  row.observation = observation;
  row.reward = simulation.reward();
  row.status = simulation.status();
  row.touching = touches_anything(simulation) ? 1 : 0;
  row.sensors = sensors;
  row.info = simulation.info();
  row.goal = goal;
  log.add(row);
}

}  // namespace skybody
