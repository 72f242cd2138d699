#include "tests/unit/plugins/small_world.h"

#include <stdlib.h>

#include <cstring>

#include "core/base/math/hash.h"
#include "core/io/yaml/parameter_reader.h"

namespace skybody::test {
namespace {

constexpr int kWidth = 16;  // values per block, enough for every test plugin

Declared& declared_of(void* host) { return *static_cast<Declared*>(host); }
void note(void* host, const std::string& line) { declared_of(host).lines.push_back(line); }

std::vector<ParameterValue> default_values(const std::vector<ParameterSpec>& specs) {
  std::vector<ParameterValue> values;
  for (const ParameterSpec& spec : specs) values.push_back(default_value(spec, {}));
  return values;
}

}  // namespace

std::filesystem::path good_plugins() { return SKYBODY_TEST_PLUGINS "/good"; }
std::filesystem::path bad_plugins() { return SKYBODY_TEST_PLUGINS "/bad"; }
std::filesystem::path twin_plugins() { return SKYBODY_TEST_PLUGINS "/twins"; }
std::filesystem::path hostile_plugins() { return SKYBODY_TEST_PLUGINS "/hostile"; }

Folder::Folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "skybody-test-XXXXXX").string();
  path_ = std::filesystem::canonical(mkdtemp(pattern.data()));
}
Folder::~Folder() { std::filesystem::remove_all(path_); }

SkybodyDeclare Declared::table() {
  SkybodyDeclare d{};
  d.host = this;
  d.input = [](void* h, int32_t signal, int32_t count, const double* low, const double* high) {
    note(h, "input " + std::to_string(signal) + " x " + std::to_string(count) + " " +
                std::to_string(low[0]) + ".." + std::to_string(high[0]));
  };
  d.output = [](void* h, int32_t, int32_t signal, int32_t count) {
    note(h, "output " + std::to_string(signal) + " x " + std::to_string(count));
  };
  d.site = [](void* h, const SkybodySite* site) { note(h, "site " + std::to_string(site->body)); };
  d.channel = [](void* h, const SkybodyChannel* c) {
    note(h, "channel " + std::string(c->name) + " x " + std::to_string(c->count));
  };
  d.period = [](void* h, int32_t steps) { note(h, "period " + std::to_string(steps)); };
  d.buffer = [](void* h, int32_t words) { declared_of(h).buffer_words = words; };
  d.bodies_before = [](void* h) { note(h, "bodies_before"); };
  d.reads = [](void* h, int32_t first) { note(h, "reads " + std::to_string(first)); };
  d.steady = [](void* h) { note(h, "steady"); };
  d.only_when_read = [](void* h) { note(h, "only_when_read"); };
  d.writes = [](void* h, int32_t param) { note(h, "writes " + std::to_string(param)); };
  d.goal = [](void* h, int32_t robot, int32_t body, const double*) {
    note(h, "goal " + std::to_string(robot) + " " + std::to_string(body));
  };
  d.robot_rewards = [](void* h) { note(h, "robot_rewards"); };
  d.info = [](void* h, const SkybodyChannel* c) {
    note(h, "info " + std::string(c->name) + " x " + std::to_string(c->count));
  };
  d.repeat = [](void* h, int32_t to, int32_t from, int32_t count) {
    note(h,
         "repeat " + std::to_string(to) + " " + std::to_string(from) + " " + std::to_string(count));
  };
  return d;
}

SmallWorld::SmallWorld(const PluginEntry& entry)
    : entry_(entry), defaults_(default_values(entry.parameters)), values_(defaults_) {
  for (std::size_t i = 0; i < defaults_.size(); ++i) {
    if (entry.parameters[i].randomizable) values_.set_env_param(i, 0);
  }
  robot_.name = "quad";
  robot_.body_count = 1;
  robot_.rotor_count = 4;
  robot_.q_count = 7;
  robot_.u_count = 6;
  robot_.rotation[0] = 1.0;
  body_.name = "base";
  body_.mass = 0.5;
  body_.joint = SKYBODY_FREE;
  SkybodyRotorInfo rotor{};
  rotor.name = "rotor";
  rotor.axis[2] = rotor.axis_in_base[2] = rotor.direction = 1.0;
  rotors_.assign(4, rotor);
  setup_.instance = "robots.quad.controllers.c";
  setup_.dt = 0.001;
  setup_.action_repeat = 1;
  setup_.gravity[2] = -9.81;
  setup_.team = team_;
  setup_.team_size = 1;
  setup_.robots = &robot_;
  setup_.robot_count = 1;
  setup_.bodies = &body_;
  setup_.body_count = 1;
  setup_.rotors = rotors_.data();
  setup_.rotor_count = 4;
  setup_.params = &param_;
  setup_.param_count = 1;
  setup_.values = values_.table().data();
  setup_.value_count = static_cast<int>(defaults_.size());
}

std::shared_ptr<const void> SmallWorld::create() {
  const SkybodyDeclare table = declared.table();
  return create_instance(entry_, setup_, table);
}

std::vector<double> Group::fill(int words, double scale, int salt) const {
  std::vector<double> values(static_cast<std::size_t>(words) * lanes_);
  for (int k = 0; k < words; ++k) {
    for (std::uint32_t l = 0; l < lanes_; ++l) {
      HashChain chain(static_cast<std::uint64_t>(salt));
      chain.update(static_cast<std::uint64_t>(k) * 1000 + l + first_);
      const double unit = static_cast<double>(chain.value() >> 11) * 0x1p-53;
      values[static_cast<std::size_t>(k) * lanes_ + l] = scale * (2.0 * unit - 1.0);
    }
  }
  return values;
}

Group::Group(std::uint32_t lanes, std::uint32_t first, std::uint32_t active, int state_words,
             int buffer_words)
    : lanes_(lanes),
      first_(first),
      active_(active),
      key_(2 * lanes, 5),
      episode_(lanes),
      step_(lanes, 3),
      physics_step_(lanes, 17),
      state_(state_words * lanes, 0),
      end_(lanes, 0) {
  for (std::uint32_t l = 0; l < lanes; ++l) {
    key_[lanes + l] = first + l;
    episode_[l] = 1 + (first + l) % 3;
  }
  bodies_ = fill(13, 2.0, 1);
  q_ = fill(kWidth, 1.0, 2);
  u_ = fill(kWidth, 1.0, 3);
  rotor_speed_ = fill(kWidth, 500.0, 4);
  params_ = fill(kWidth, 1.0, 5);
  sensors_ = fill(kWidth, 1.0, 6);
  action_ = fill(kWidth, 1.0, 7);
  command_ = fill(kWidth, 1.0, 8);
  input_ = fill(kWidth, 1000.0, 9);
  output_ = fill(kWidth, 1.0, 10);
  observation_ = fill(kWidth, 1.0, 11);
  reward_ = fill(1, 1.0, 12);
  robot_reward_ = fill(kWidth, 1.0, 15);
  info_ = fill(kWidth, 1.0, 16);
  goal_ = fill(4, 1.0, 13);
  buffer_ = fill(buffer_words, 1.0, 14);
}

SkybodyLanes Group::view() {
  SkybodyLanes v{};
  v.lanes = lanes_;
  v.active = active_;
  v.key = key_.data();
  v.episode = episode_.data();
  v.step = step_.data();
  v.physics_step = physics_step_.data();
  v.bodies = bodies_.data();
  v.q = q_.data();
  v.u = u_.data();
  v.rotor_speed = rotor_speed_.data();
  v.rotor_command = rotor_speed_.data();
  v.params = params_.data();
  v.sensors = sensors_.data();
  v.action = action_.data();
  v.command = command_.data();
  return v;
}

void Group::run(const SkybodyKernels& k, const void* self, int steps) {
  SkybodyLanes v = view();
  std::uint64_t* state = state_.data();
  double* buffer = buffer_.data();
  const SkybodyStart start{q_.data(), u_.data(), rotor_speed_.data(), params_.data(), 0};
  const SkybodyEvaluation evaluation{observation_.data(),  reward_.data(), end_.data(),
                                     robot_reward_.data(), info_.data(),   1};
  if (k.reset != nullptr) k.reset(self, &v, state, buffer);
  for (int i = 0; i < steps; ++i) {
    if (k.process != nullptr) k.process(self, &v, state, buffer, action_.data(), command_.data());
    if (k.control != nullptr) k.control(self, &v, state, buffer, input_.data(), output_.data());
    if (k.sense != nullptr) k.sense(self, &v, state, buffer, output_.data());
    if (k.randomize != nullptr) k.randomize(self, &v, state, buffer, &start);
    if (k.evaluate != nullptr) k.evaluate(self, &v, state, buffer, &evaluation);
    if (k.goal != nullptr) k.goal(self, &v, state, buffer, goal_.data());
    for (std::uint32_t l = 0; l < lanes_; ++l) {
      bodies_[2 * lanes_ + l] += 0.01 * static_cast<double>(i);
      ++physics_step_[l];
    }
  }
}

std::vector<std::uint64_t> Group::lane(std::uint32_t l) const {
  return words(
      l, {&q_, &u_, &rotor_speed_, &params_, &command_, &output_, &observation_, &reward_, &goal_});
}

std::vector<std::uint64_t> Group::kept(std::uint32_t l, bool with_output) const {
  if (with_output) return words(l, {&q_, &u_, &rotor_speed_, &params_, &command_, &output_});
  return words(l, {&q_, &u_, &rotor_speed_, &params_, &command_});
}

std::vector<std::uint64_t> Group::words(
    std::uint32_t l, std::initializer_list<const std::vector<double>*> blocks) const {
  std::vector<std::uint64_t> all;
  const auto add = [&](const auto& block) {
    for (std::size_t i = l; i < block.size(); i += lanes_) {
      std::uint64_t word;
      std::memcpy(&word, &block[i], sizeof word);
      all.push_back(word);
    }
  };
  add(state_);
  add(buffer_);
  add(end_);
  for (const auto* block : blocks) {
    add(*block);
  }
  return all;
}

}  // namespace skybody::test
