// Plugins inside the test program: the engine's tests need no shared libraries.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "core/base/simd/isa.h"
#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_instance.h"
#include "core/io/yaml/parameter_reader.h"
#include "core/plugin_host/descriptor.h"
#include "core/plugin_host/instance.h"
#include "plugins/api/export.h"

namespace skybody::test {

class InProcessFactory : public PluginFactory {
 public:
  template <class T>
  void add(const std::string& name) {
    auto description = std::make_shared<plugin_export::Description<T>>("test", "0", "test");
    const SkybodyPlugin* plugin = description->plugin();
    plugins_[name] = {{description, plugin}, parameter_specs(*plugin)};
  }

  Made make(SkybodyKind, const std::string& plugin, const SkybodySetup& setup,
            const SkybodyDeclare& declare) override {
    const SkybodyPlugin& p = *plugins_.at(plugin).descriptor;
    char error[512] = "";
    void* self = p.create(&setup, &declare, error, sizeof error);
    if (self == nullptr) throw Error(error);
    return {std::shared_ptr<const void>(self, p.destroy), kernels_for(p, best_isa()),
            static_cast<int>(p.state_words), "", kernels_for(p, best_isa(), SKYBODY_NUMBER_DUAL)};
  }

  const std::vector<ParameterSpec>& parameters(SkybodyKind, const std::string& plugin) override {
    return plugins_.at(plugin).parameters;
  }

  /// A plugin use with all defaults, as the scenario reader would set them.
  PluginUse use(const std::string& plugin, const std::string& instance) const {
    PluginUse u;
    u.plugin = plugin;
    u.instance = instance;
    u.mark = {"test.yaml", 1, 1};
    for (const ParameterSpec& spec : plugins_.at(plugin).parameters) {
      u.parameters.push_back(default_value(spec, u.mark));
    }
    return u;
  }

 private:
  struct Plugin {
    std::shared_ptr<const SkybodyPlugin> descriptor;
    std::vector<ParameterSpec> parameters;
  };
  std::map<std::string, Plugin> plugins_;
};

/// A quadrotor cross of 1 kg with 4 rotors at 0.1 m, k_f = 1e-6 N s^2, no rotor lag.
inline RobotModel quadrotor() {
  RobotModel m;
  m.name = "quad";
  Body body;
  body.name = "base";
  body.mass = {1.0, {0, 0, 0}, {0.01, 0.01, 0.02, 0, 0, 0}};
  m.bodies.push_back(body);
  m.links.push_back({"base", 0, {}, {0, 0, 0}});
  for (int i = 0; i < 4; ++i) {
    Rotor r;
    r.name = "rotor" + std::to_string(i);
    r.set_position({i < 2 ? 0.1 : -0.1, (i % 2) == 0 ? 0.1 : -0.1, 0.0});
    r.direction = (i == 0 || i == 3) ? 1 : -1;
    r.constants[kThrustConstant] = 1e-6;
    r.constants[kMomentConstant] = 1e-8;
    r.constants[kMaxSpeed] = 4000.0;
    m.rotors.push_back(r);
  }
  return m;
}

/// Group, workspace and rows of one environment, ready to reset.
struct Flight {
  Flight(const CompiledScenario& compiled, int lanes, std::uint64_t seed = 1)
      : env(compiled),
        group(compiled.make_state(lanes)),
        work(compiled.make_workspace(lanes)),
        observation(static_cast<std::size_t>(lanes * compiled.observation_size())),
        reward(static_cast<std::size_t>(lanes)),
        status(static_cast<std::size_t>(lanes)),
        all(first_lanes(lanes)) {
    for (int l = 0; l < lanes; ++l) env.initialize(group, l, seed, static_cast<std::uint64_t>(l));
  }
  Rows rows() { return {observation.data(), reward.data(), status.data()}; }
  void reset() { env.reset(group, *work, all, rows()); }
  void step(const std::vector<float>& actions) {
    env.step(group, *work, all, actions.data(), env.action_size(), rows());
  }

  const CompiledScenario& env;
  StateGroup group;
  std::unique_ptr<GroupWorkspace> work;
  std::vector<float> observation, reward;
  std::vector<std::uint64_t> status;
  std::uint32_t all;
};

}  // namespace skybody::test
