#include "core/simulation/simulation.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/simd/fp_environment.h"
#include "core/base/system/arguments.h"
#include "core/base/system/error.h"
#include "core/env/param_access.h"
#include "core/env/random_key.h"
#include "core/simulation/simulation_data.h"

namespace skybody {

Simulation::Simulation(const SimulationOptions& options)
    : Simulation(compile_scenario({options.scenario, options.overrides, options.plugin_path}),
                 options.seed, options.env_id) {}

Simulation::Simulation(std::shared_ptr<const CompiledScenario> compiled, std::uint64_t seed,
                       std::uint64_t env_id)
    : compiled_(std::move(compiled)), data_(std::make_unique<Data>(*compiled_, seed, env_id)) {}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

void Simulation::reset() {
  const FpEnvironment guard;
  Data::Requests& requests = data_->requests_at_reset;
  std::move(data_->requests_now.begin(), data_->requests_now.end(), std::back_inserter(requests));
  data_->requests_now.clear();
  data_->work->requests[0] = requests;
  compiled_->reset(data_->group, *data_->work, 1u, data_->rows());
  data_->work->clear_requests();
  requests.clear();
  add_to_hash();
  data_->started = true;
}

void Simulation::reset(std::uint64_t seed) {
  compiled_->initialize(data_->group, 0, seed, data_->group.bits(kEnvId)[0]);
  reset();
}

void Simulation::step(std::span<const float> action) {
  demand_started("step");
  check_values("action", action.size(), 1, action_size());
  const FpEnvironment guard;
  apply_requests();
  compiled_->step(data_->group, *data_->work, 1u, action.data(), action_size(), data_->rows());
  add_to_hash();
}

void Simulation::keep_hash(bool keep) { data_->keeps_hash = keep; }

void Simulation::add_to_hash() {
  if (data_->keeps_hash) compiled_->hash(data_->group, 0, data_->rows(), data_->chain);
}

std::span<const float> Simulation::privileged() const { return data_->privileged; }
std::span<const std::uint8_t> Simulation::image(int image) const {
  check_index("image", image, static_cast<int>(compiled_->images().size()));
  const ObservedImage& place = compiled_->images()[static_cast<std::size_t>(image)];
  return {data_->group.images().bytes_of(0) + place.from, static_cast<std::size_t>(place.bytes)};
}
std::span<const float> Simulation::observation() const { return data_->observation; }
std::span<const float> Simulation::agent_rewards() const { return data_->agent_reward; }
std::span<const float> Simulation::info() const { return data_->info; }
float Simulation::reward() const { return data_->reward; }
bool Simulation::terminated() const { return (data_->status & kTerminated) != 0; }
bool Simulation::truncated() const { return (data_->status & kTruncated) != 0; }
std::uint64_t Simulation::status() const { return data_->status; }
bool Simulation::fault() const { return (data_->status & kFault) != 0; }
int Simulation::action_size() const { return compiled_->action_size(); }
int Simulation::observation_size() const { return compiled_->observation_size(); }
const StepCounts& Simulation::step_counts() const { return data_->group.step_counts(); }
std::uint64_t Simulation::episode() const { return data_->group.bits(kEpisode)[0]; }
std::uint64_t Simulation::steps() const { return data_->group.bits(kStep)[0]; }
std::uint64_t Simulation::physics_steps() const { return data_->group.bits(kPhysicsStep)[0]; }
double Simulation::time() const {
  return static_cast<double>(physics_steps()) * scenario().stepping.dt;
}

void Simulation::touch() const {
  const FpEnvironment guard;
  compiled_->update(data_->group, *data_->work, 1u);
}

const std::vector<BodyState>& Simulation::bodies() const {
  touch();
  return data_->bodies = data_->group.body_states(0);
}

const BodyState& Simulation::body(const std::string& robot, const std::string& link) const {
  return bodies()[static_cast<std::size_t>(body_index(robot, link))];
}

const BodyState& Simulation::base(const std::string& robot) const {
  const auto r = static_cast<std::size_t>(robot_index(robot));
  return bodies()[static_cast<std::size_t>(compiled_->layout().robots[r].first_body)];
}

namespace {
std::vector<double> block_of(const StateGroup& group, Block block) {
  std::vector<double> values(static_cast<std::size_t>(block.size));
  group.gather(0, block, values.data());
  return values;
}
}  // namespace

std::vector<double> Simulation::rotor_speeds() const {
  return block_of(data_->group, compiled_->layout().rotor_speed);
}
std::vector<double> Simulation::rotor_commands() const {
  return block_of(data_->group, compiled_->layout().rotor_command);
}
std::vector<double> Simulation::commands() const {
  return block_of(data_->group, compiled_->layout().command);
}
std::vector<double> Simulation::actions() const {
  return block_of(data_->group, compiled_->layout().action);
}
std::vector<double> Simulation::sensors() const {
  return block_of(data_->group, compiled_->layout().sensors);
}
std::vector<double> Simulation::params() const {
  return block_of(data_->group, compiled_->layout().params);
}

std::vector<double> Simulation::goals() const {
  touch();
  std::vector<double> out;
  compiled_->goal(data_->group, *data_->work, 0, out);
  return out;
}

std::vector<double> Simulation::goal_motions() const {
  touch();
  std::vector<double> out;
  compiled_->goal_motion(data_->group, *data_->work, 0, out);
  return out;
}

std::vector<double> Simulation::state(std::string_view path) const {
  const StateValue& value = compiled_->state_values().at(path);
  std::vector<double> values(static_cast<std::size_t>(value.count()));
  state(value, values);
  return values;
}

void Simulation::state(const StateValue& value, std::span<double> values) const {
  check_values("values", values.size(), 1, value.count());
  if (value.needs_bodies()) touch();
  const FpEnvironment guard;
  compiled_->state_values().read(value, data_->group, 0, values.data());
}

double Simulation::param(const std::string& path) const {
  return get_param(*compiled_, data_->group, 0, path);
}

void Simulation::set_param(const std::string& path, double value) {
  skybody::set_param(*compiled_, data_->group, 0, path, value);
}

void Simulation::request(std::span<const ParamChange> changes, RequestTime when) {
  auto& requests = when == RequestTime::kNextReset ? data_->requests_at_reset : data_->requests_now;
  requests.push_back(std::make_shared<const ParamRequest>(*compiled_, changes, false));
}

void Simulation::apply_requests() {
  for (const auto& request : data_->requests_now) {
    compiled_->apply(data_->group, *data_->work, 0, *request);
  }
  data_->requests_now.clear();
}

void Simulation::randomize() {
  const FpEnvironment guard;
  compiled_->randomize(data_->group, *data_->work, 1u);
}

Snapshot Simulation::save() const {
  Snapshot s;
  s.scenario_hash = scenario().hash;
  s.words = data_->group.save(0);
  s.observation = data_->observation;
  s.agent_rewards = data_->agent_reward;
  s.info = data_->info;
  s.privileged = data_->privileged;
  s.reward = data_->reward;
  s.trajectory = data_->chain;
  s.started = data_->started;
  return s;
}

void Simulation::restore(const Snapshot& snapshot) {
  if (snapshot.scenario_hash != scenario().hash ||
      snapshot.words.size() != compiled_->saved_words()) {
    throw Error("this snapshot is of another scenario than " + scenario().file +
                ": restore it where it was saved");
  }
  data_->group.restore(0, snapshot.words);
  if (!compiled_->images().empty()) {
    const FpEnvironment guard;
    compiled_->update(data_->group, *data_->work, 1u);
  }
  data_->status = data_->group.bits(kStatus)[0];
  data_->observation = snapshot.observation;
  data_->agent_reward = snapshot.agent_rewards;
  data_->info = snapshot.info;
  data_->privileged = snapshot.privileged;
  data_->reward = snapshot.reward;
  data_->chain = snapshot.trajectory;
  data_->started = snapshot.started;
}

Simulation Simulation::fork(bool rekey) {
  if (rekey) count_fork(data_->group, 0);
  Simulation copy(compiled_, 0, 0);
  copy.restore(save());
  if (rekey) give_fork_key(copy.data_->group, 0);
  return copy;
}

std::uint64_t Simulation::hash() const { return data_->chain.value(); }

}  // namespace skybody
