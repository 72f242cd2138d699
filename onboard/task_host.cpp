#include "onboard/task_host.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/base/simd/fp_environment.h"

namespace skybody::onboard {
namespace {

TaskSizes& sizes_of(void* host) { return *static_cast<TaskSizes*>(host); }

/// Declarations that change nothing on a vehicle.
void declare_quietly(SkybodyDeclare& d) {
  d.input = [](void*, std::int32_t, std::int32_t, const double*, const double*) {};
  d.output = [](void*, std::int32_t, std::int32_t, std::int32_t) {};
  d.site = [](void*, const SkybodySite*) {};
  d.joint = [](void*, const SkybodyJointDrive*) {};
  d.holds = [](void*, std::int32_t) {};
  d.steady = [](void*) {};
  d.report = [](void*, const SkybodyChannel*, std::int32_t) {};
  d.reads = [](void*, std::int32_t) {};
  d.only_when_read = [](void*) {};
  d.writes = [](void*, std::int32_t) {};
  d.draws_in_time = [](void*) {};
  d.goal = [](void*, std::int32_t, std::int32_t, const double*) {};
  d.robot_rewards = [](void*) {};
  d.repeat = [](void*, std::int32_t, std::int32_t, std::int32_t) {};
  d.interpolate = [](void*) {};
  d.offers = [](void*, const char*, std::int32_t, std::int32_t, std::int32_t) {};
}

/// Declarations of values that a vehicle does not have.
void declare_missing(SkybodyDeclare& d) {
  d.contacts = [](void* host) { sizes_of(host).missing = "contacts"; };
  d.contact_pair = [](void* host, std::int32_t, std::int32_t, std::int32_t) {
    sizes_of(host).missing = "contacts";
    return 0;
  };
  d.joint_reaction = [](void* host, std::int32_t) {
    sizes_of(host).missing = "reactions of joints";
    return 0;
  };
  d.bodies_before = [](void* host) { sizes_of(host).missing = "states before a physics step"; };
  d.offered = [](void* host, const char*, std::int32_t, std::int32_t) {
    sizes_of(host).missing = "values of effects";
    return 0;
  };
}

SkybodyDeclare declare_into(TaskSizes& sizes) {
  SkybodyDeclare d{};
  d.host = &sizes;
  declare_quietly(d);
  declare_missing(d);
  d.channel = [](void* host, const SkybodyChannel* c) { sizes_of(host).observation += c->count; };
  d.info = [](void* host, const SkybodyChannel* c) { sizes_of(host).info += c->count; };
  d.period = [](void* host, std::int32_t) { sizes_of(host).has_period = true; };
  d.buffer = [](void* host, std::int32_t words) { sizes_of(host).buffer = words; };
  d.scratch = [](void* host, std::int32_t values) { sizes_of(host).scratch = values; };
  d.scratch_block = d.scratch;
  d.memo = [](void* host, std::int32_t values) { sizes_of(host).memo = values; };
  d.action = [](void* host, const SkybodyChannel*) { sizes_of(host).has_own_action = true; };
  return d;
}

/// A file in memory. @throws Error
int file_of(const std::string& content) {
  const int file = memfd_create("skybody-mission", 0);
  const auto size = static_cast<ssize_t>(content.size());
  if (file >= 0 && write(file, content.data(), content.size()) == size) return file;
  throw Error("no memory for a file of the mission");
}

std::size_t at_least_one(int count) { return static_cast<std::size_t>(std::max(1, count)); }

}  // namespace

TaskHost::TaskHost(const Mission& mission) : mission_(mission), setup_(mission.setup) {
  plugin_ = find_task(mission.task);
  if (plugin_ == nullptr) {
    std::string known;
    for (const std::string& name : task_names()) known += (known.empty() ? "" : ", ") + name;
    throw Error("the task `" + mission.task + "` is not in this program; it has " + known +
                " (CMake: SKYBODY_ONBOARD_TASKS)");
  }
  if (mission.task_version != plugin_->version) {
    throw Error("the mission has version " + mission.task_version + " of the task `" +
                mission.task + "`, this program " + plugin_->version +
                ": build the program and export the mission from the same sources");
  }
  kernels_ = plugin_->kernels[SKYBODY_NUMBER_REAL][0];
  keep_files();
  create();
}

TaskHost::~TaskHost() {
  if (self_ != nullptr) plugin_->destroy(self_);
  for (const int file : files_) close(file);
}

/// Gives the mission's files paths, under which the task opens them.
void TaskHost::keep_files() {
  for (SetupValue& value : setup_.values()) {
    for (std::size_t k = 0; k < value.contents.size() && k < value.texts.size(); ++k) {
      if (value.texts[k].empty()) continue;
      files_.push_back(file_of(value.contents[k]));
      value.texts[k] = "/proc/self/fd/" + std::to_string(files_.back());
    }
  }
  setup_.link();
}

void TaskHost::create() {
  const FpEnvironment guard;
  char error[2048] = {};
  const SkybodyDeclare declare = declare_into(sizes_);
  self_ = plugin_->create(&setup_.setup(), &declare, error, sizeof error);
  if (self_ == nullptr) throw Error("the task `" + mission_.task + "`: " + error);
  if (!sizes_.missing.empty() || sizes_.has_period) {
    throw Error("the task `" + mission_.task + "` needs " +
                (sizes_.has_period ? "commands between two actions" : sizes_.missing) +
                ", which a vehicle does not have");
  }
  state_.resize(plugin_->state_words + at_least_one(sizes_.buffer));
  scratch_.resize(at_least_one(sizes_.scratch));
  memo_.resize(at_least_one(sizes_.memo));
  int values = std::max(sizes_.observation, mission_.policy.observation_size);
  for (const Part& part : mission_.parts) values = std::max(values, part.to + part.count);
  values_.resize(at_least_one(values));
  info_.resize(at_least_one(sizes_.info));
  robot_reward_.resize(setup_.robots().size());
  action_.resize(static_cast<std::size_t>(mission_.policy.action_size));
  scaled_.resize(action_.size());
  int commands = 1;
  for (const SkybodyChainInfo& c : setup_.chains()) {
    commands = std::max(commands, c.first_command + c.count);
  }
  command_.resize(static_cast<std::size_t>(commands));
  key_[0] = mission_.seed;
}

SkybodyLanes TaskHost::lanes(const Situation& s) {
  step_ = s.step;
  physics_step_ = s.physics_step;
  checks_ = {};
  checks_.bodies = s.body_count();
  const auto size = [](const std::vector<double>& v) {
    return static_cast<std::int32_t>(v.size());
  };
  checks_.q = size(s.q);
  checks_.u = size(s.u);
  checks_.rotors = size(s.rotor_speed);
  checks_.params = size(s.params);
  checks_.sensors = size(s.sensors);
  checks_.action = size(action_);
  checks_.command = size(command_);
  checks_.robots = size(robot_reward_);
  checks_.buffer = sizes_.buffer;
  checks_.scratch = sizes_.scratch;
  checks_.memo = sizes_.memo;
  checks_.output = sizes_.observation;
  checks_.info = sizes_.info;
  SkybodyLanes l{};
  l.lanes = 1;
  l.active = 1;
  l.key = key_;
  l.episode = &episode_;
  l.step = &step_;
  l.physics_step = &physics_step_;
  l.bodies = s.bodies.data();
  l.q = s.q.data();
  l.u = s.u.data();
  l.rotor_speed = l.rotor_command = s.rotor_speed.data();
  l.params = s.params.data();
  l.sensors = s.sensors.data();
  l.action = action_.data();
  l.command = command_.data();
  l.scratch = scratch_.data();
  l.memo = memo_.data();
  l.checks = &checks_;
  return l;
}

void TaskHost::reset(const Situation& situation) {
  const FpEnvironment guard;
  std::fill(state_.begin(), state_.end(), 0u);
  std::fill(action_.begin(), action_.end(), 0.0);
  std::fill(command_.begin(), command_.end(), 0.0);
  const SkybodyLanes l = lanes(situation);
  if (kernels_.reset != nullptr) kernels_.reset(self_, &l, words(), buffer());
}

void TaskHost::observe(const Situation& situation, std::span<const float> action,
                       std::span<float> observation) {
  const FpEnvironment guard;
  if (situation.step > 0) std::copy(action.begin(), action.end(), action_.begin());
  const SkybodyLanes l = lanes(situation);
  double reward = 0.0;
  std::uint64_t end = 0;
  const SkybodyEvaluation out{values_.data(), &reward, &end, robot_reward_.data(), info_.data(), 0};
  kernels_.evaluate(self_, &l, words(), buffer(), &out);
  if (mission_.is_task_in_place) {
    std::copy_n(values_.begin(), observation.size(), observation.begin());
  }
  for (const Part& part : mission_.parts) {
    const std::vector<double>& from = part.is_of_task ? values_ : situation.sensors;
    for (int k = 0; k < part.count; ++k) {
      const auto to = static_cast<std::size_t>(part.to + k);
      if (to >= observation.size()) continue;  // of the critic
      observation[to] = static_cast<float>(from[static_cast<std::size_t>(part.from + k)]);
    }
  }
}

void TaskHost::command(const Situation& situation, std::span<const float> action,
                       std::span<double> command) {
  const FpEnvironment guard;
  std::copy(action.begin(), action.end(), action_.begin());
  const bool is_processed = kernels_.process != nullptr;
  std::vector<double>& scaled = is_processed ? scaled_ : command_;
  for (const ActionRange& range : mission_.actions) {
    for (std::size_t k = 0; k < range.low.size(); ++k) {
      const std::size_t at = static_cast<std::size_t>(range.first) + k;
      if (at >= scaled.size()) continue;
      scaled[at] = range.low[k] + 0.5 * (action_[at] + 1.0) * (range.high[k] - range.low[k]);
    }
  }
  if (is_processed) {
    SkybodyLanes l = lanes(situation);
    checks_.output = static_cast<std::int32_t>(command_.size());
    checks_.input = static_cast<std::int32_t>(action_.size());
    const double* in = sizes_.has_own_action ? scaled_.data() : action_.data();
    kernels_.process(self_, &l, words(), buffer(), in, command_.data());
  }
  const auto first = command_.begin() + mission_.chain().first_command;
  std::copy_n(first, command.size(), command.begin());
}

}  // namespace skybody::onboard
