// Loads a shipped plugin's library, makes an instance in a PluginWorld and calls its kernels on
// groups of environments.
#pragma once

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/simd/isa.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/plugin_setup_tables.h"
#include "core/io/yaml/parameter_reader.h"
#include "core/model/held_inputs.h"
#include "core/plugin_host/descriptor.h"
#include "tests/unit/plugin_group.h"
#include "tests/unit/plugin_world.h"

namespace skybody::testing {

/// A parameter value given by a test.
struct Given {
  std::vector<double> numbers;
  std::vector<std::string> texts;
  Given(double number) : numbers{number} {}
  Given(int number) : numbers{static_cast<double>(number)} {}
  Given(bool value) : numbers{value ? 1.0 : 0.0} {}
  Given(const char* text) : texts{text} {}
  Given(std::vector<double> list) : numbers(std::move(list)) {}
  Given(std::vector<std::string> list) : texts(std::move(list)) {}
};
using Parameters = std::map<std::string, Given>;

/// Names of channels with their robots.
inline std::vector<std::string> channel_names(const std::vector<Channel>& channels) {
  std::vector<std::string> out;
  for (const Channel& c : channels) out.push_back(c.name);
  return out;
}
inline std::vector<int> channel_robots(const std::vector<Channel>& channels) {
  std::vector<int> out;
  for (const Channel& c : channels) out.push_back(c.robot);
  return out;
}

/// One instance of a plugin.
class Instance {
 public:
  /// @param name  of a shipped plugin; with a `/`: the library's path in the build folder
  /// @throws std::runtime_error with configure()'s message
  Instance(const std::string& name, PluginWorld& world, const Parameters& given = {})
      : world_(world), name_("test." + name) {
    const bool is_shipped = name.find('/') == std::string::npos;
    const std::string file = std::string(SKYBODY_BINARY_DIR) + "/" +
                             (is_shipped ? "lib/skybody/plugins/" : "") + name + ".so";
    library_.reset(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL), [](void* h) {
      if (h != nullptr) dlclose(h);
    });
    if (!library_) throw std::logic_error(dlerror());
    const auto* exported =
        static_cast<const SkybodyPluginLibrary*>(dlsym(library_.get(), SKYBODY_LIBRARY_SYMBOL));
    plugin_ = exported->plugins[0];
    bind(given);
    const SkybodyDeclare declare = declare_into(declared);
    const SkybodySetup setup = world.setup(name_.c_str(), values_.table());
    char error[1024] = "";
    self_ = plugin_->create(&setup, &declare, error, sizeof(error));
    if (self_ == nullptr) throw std::runtime_error(error);
  }
  ~Instance() {
    if (self_ != nullptr) plugin_->destroy(self_);
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  PluginInstance declared;  ///< by configure()
  const SkybodyPlugin& plugin() const { return *plugin_; }
  int env_param(const std::string& parameter) const { return env_params_.at(parameter); }

  /// Environments at rest at their scenario poses, nominal parameters, state 0.
  Group group(int lanes) const {
    Group g;
    g.lanes = lanes;
    const auto n = [&](int count) { return static_cast<std::size_t>(count * lanes); };
    g.key.assign(n(2), 7);
    g.episode.assign(n(1), 1);
    g.step.assign(n(1), 0);
    g.physics_step.assign(n(1), 0);
    g.state.assign(n(static_cast<int>(plugin_->state_words)), 0);
    g.end.assign(n(1), 0);
    g.q.assign(n(world_.q), 0.0);
    g.u.assign(n(world_.u), 0.0);
    g.rotor_speed.assign(n(static_cast<int>(world_.rotors.size())), 0.0);
    g.rotor_command = g.rotor_speed;
    g.action.assign(n(world_.actions), 0.0);
    g.command.assign(n(world_.actions), 0.0);
    g.buffer.assign(n(declared.memory.buffer_words), 0.0);
    g.memo.assign(n(declared.memory.memo), 0.0);
    g.scratch.assign(n(declared.memory.scratch), 0.0);
    g.input.assign(n(static_cast<int>(declared.controller.low.size())), 0.0);
    g.output.assign(n(std::max(declared.controller.output_count(), declared.channel_count())), 0.0);
    g.observation.assign(n(declared.channel_count()), 0.0);
    g.reward.assign(n(1), 0.0);
    g.robot_reward.assign(n(static_cast<int>(world_.robots.size())), 0.0);
    g.info.assign(n(value_count(declared.task.infos)), 0.0);
    for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
      const auto input = static_cast<std::size_t>(i);
      const HeldInputRow& row = kHeldInputs[input];
      const auto owners = row.is_of_rotors ? world_.rotors.size() : world_.bodies.size();
      const int count = declared.effect.holds[input] ? row.size * static_cast<int>(owners) : 0;
      for (int k = 0; k < count; ++k) {
        g.held[input].insert(g.held[input].end(), static_cast<std::size_t>(lanes),
                             neutral_value(i, k % row.size));
      }
    }
    g.bodies.assign(n(13 * static_cast<int>(world_.bodies.size())), 0.0);
    g.params.assign(n(static_cast<int>(world_.params.size())), 0.0);
    for (int l = 0; l < lanes; ++l) {
      for (std::size_t k = 0; k < world_.params.size(); ++k) {
        g.at(g.params, static_cast<int>(k), l) = world_.params[k].nominal;
      }
      for (std::size_t b = 0; b < world_.bodies.size(); ++b) {
        const SkybodyRobotInfo& robot =
            world_.robots[static_cast<std::size_t>(world_.bodies[b].robot)];
        const int first = 13 * static_cast<int>(b);
        for (int k = 0; k < 3; ++k) g.at(g.bodies, first + k, l) = robot.position[k];
        g.at(g.bodies, first + 3, l) = 1.0;
      }
    }
    g.before = g.bodies;
    g.contacts.assign(n(SKYBODY_CONTACT_VALUES * static_cast<int>(world_.bodies.size())), 0.0);
    g.contact_pairs.assign(
        n(SKYBODY_CONTACT_VALUES * static_cast<int>(declared.contact_pairs.size())), 0.0);
    g.joint_reactions.assign(
        n(SKYBODY_REACTION_VALUES * static_cast<int>(declared.joint_reactions.size())), 0.0);
    g.sensors.assign(n(world_.sensor_values), 0.0);
    g.offered.assign(n(declared.sensor.requested()), 0.0);
    return g;
  }

  enum class Call {
    kReset,
    kControl,
    kSense,
    kRandomize,
    kRequest,
    kInTime,
    kProcess,
    kEvaluate,
    kApply
  };
  /// Calls one step function of an instruction set (0, 1, 2: v2, v3, v4) for the lanes of `mask`.
  /// Copies repeated values, which packs may omit, as rows do.
  void copy_repeats(Group& g, std::uint32_t mask) const {
    for (const ValueCopy& copy : declared.task.repeats) {
      for (int k = 0; k < copy.count; ++k) {
        each_lane(mask, [&](int l) {
          g.at(g.observation, copy.to + k, l) = g.at(g.observation, copy.from + k, l);
        });
      }
    }
  }

  void call(Call what, Group& g, std::uint32_t mask = 1, int set = 0,
            SkybodyNumber number = SKYBODY_NUMBER_REAL) const {
    const SkybodyKernels& k = plugin_->kernels[number][set];
    const SkybodyLanes v = view(g, mask);
    std::uint64_t* state = g.state.data();
    double* buffer = g.buffer.data();
    const std::uint32_t occasion = what == Call::kRequest  ? SKYBODY_ON_REQUEST
                                   : what == Call::kInTime ? SKYBODY_IN_TIME
                                                           : SKYBODY_AT_RESET;
    const SkybodyStart start{g.q.data(), g.u.data(), g.rotor_speed.data(), g.params.data(),
                             occasion};
    const SkybodyEvaluation out{g.observation.data(),  g.reward.data(), g.end.data(),
                                g.robot_reward.data(), g.info.data(),   1};
    SkybodyHeld held{};
    for (std::size_t i = 0; i < g.held.size(); ++i) {
      held.input[i] = g.held[i].empty() ? nullptr : g.held[i].data();
    }
    switch (what) {
      case Call::kReset:
        if (plugin_->kind == SKYBODY_TASK && k.randomize != nullptr) {
          k.randomize(self_, &v, state, buffer, &start);
        }
        if (k.reset != nullptr) k.reset(self_, &v, state, buffer);
        break;
      case Call::kControl:
        k.control(self_, &v, state, buffer, g.input.data(), g.output.data());
        break;
      case Call::kSense:
        k.sense(self_, &v, state, buffer, g.output.data());
        break;
      case Call::kRandomize:
      case Call::kRequest:
      case Call::kInTime:
        k.randomize(self_, &v, state, buffer, &start);
        break;
      case Call::kProcess:
        k.process(self_, &v, state, buffer, g.action.data(), g.command.data());
        break;
      case Call::kEvaluate:
        k.evaluate(self_, &v, state, buffer, &out);
        if (number == SKYBODY_NUMBER_REAL) copy_repeats(g, mask);
        break;
      case Call::kApply:
        k.apply(self_, &v, state, buffer, &held);
        break;
    }
  }
  /// The main step function of its kind.
  Call main_call() const {
    const Call calls[] = {Call::kControl, Call::kSense, Call::kRandomize, Call::kEvaluate,
                          Call::kApply};
    return calls[plugin_->kind];
  }
  std::vector<double> goal(Group& g) const {
    std::vector<double> goal(4 * declared.task.goals.size() * static_cast<std::size_t>(g.lanes));
    const SkybodyLanes v = view(g, 1);
    plugin_->kernels[SKYBODY_NUMBER_REAL][0].goal(self_, &v, g.state.data(), g.buffer.data(),
                                                  goal.data());
    return goal;
  }

  /// Velocity and acceleration of each goal.
  std::vector<double> goal_motion(Group& g) const {
    std::vector<double> motion(6 * declared.task.goals.size() * static_cast<std::size_t>(g.lanes));
    const SkybodyLanes v = view(g, 1);
    plugin_->kernels[SKYBODY_NUMBER_REAL][0].goal_motion(self_, &v, g.state.data(), g.buffer.data(),
                                                         motion.data());
    return motion;
  }

 private:
  static SkybodyLanes view(Group& g, std::uint32_t mask) {
    SkybodyLanes v{};
    v.lanes = static_cast<std::uint32_t>(g.lanes);
    v.active = mask;
    v.key = g.key.data();
    v.episode = g.episode.data();
    v.step = g.step.data();
    v.physics_step = g.physics_step.data();
    v.bodies = g.bodies.data();
    v.bodies_before = g.before.data();
    static constexpr std::int32_t kRows[] = {0, 1, 2, 3, 4, 5, 6, 7};
    v.contacts = g.contacts.data();
    v.contact_pairs = g.contact_pairs.data();
    v.joint_reactions = g.joint_reactions.data();
    v.sensors = g.sensors.data();
    v.plugin_words = g.offered.data();
    v.offered = kRows;
    v.q = g.q.data();
    v.u = g.u.data();
    v.rotor_speed = g.rotor_speed.data();
    v.rotor_command = g.rotor_command.data();
    v.params = g.params.data();
    v.action = g.action.data();
    v.command = g.command.data();
    v.memo = g.memo.data();
    v.scratch = g.scratch.data();
    return v;
  }

  void bind(const Parameters& given) {
    const std::vector<ParameterSpec> specs = parameter_specs(*plugin_);
    std::size_t used = 0;
    for (const ParameterSpec& spec : specs) {
      ParameterValue& value = parameters_.emplace_back(default_value(spec, {}));
      const auto found = given.find(spec.name);
      if (found == given.end()) continue;
      ++used;
      value.is_given = true;
      value.numbers = found->second.numbers;
      value.texts = found->second.texts;
    }
    if (used != given.size()) throw std::logic_error("a parameter in the test is not declared");
    values_ = BoundValues(parameters_);
    for (std::size_t i = 0; i < specs.size(); ++i) {
      const bool is_drawn = !specs[i].when_given || parameters_[i].is_given;
      if (specs[i].randomizable && is_drawn) add_params(i, specs[i]);
    }
  }

  void add_params(std::size_t index, const ParameterSpec& spec) {
    const auto first = static_cast<int>(world_.params.size());
    values_.set_env_param(index, first);
    env_params_[spec.name] = first;
    const std::vector<double>& numbers = parameters_[index].numbers;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      world_.add_param(name_ + "." + spec.name + "[" + std::to_string(k) + "]", numbers[k],
                       spec.min, spec.max);
    }
  }

  PluginWorld& world_;
  std::string name_;
  std::shared_ptr<void> library_;
  const SkybodyPlugin* plugin_ = nullptr;
  void* self_ = nullptr;
  std::vector<ParameterValue> parameters_;
  BoundValues values_{parameters_};
  std::map<std::string, int> env_params_;
};

/// The message with which configure() refuses, or "".
inline std::string refusal(const std::string& plugin, PluginWorld& world, const Parameters& given) {
  try {
    const Instance instance(plugin, world, given);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

}  // namespace skybody::testing
