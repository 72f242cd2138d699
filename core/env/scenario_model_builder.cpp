// Builds a ScenarioModel: adds parameters of plugins to the state words, configures plugins and
// checks signals.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/system/error.h"
#include "core/env/check_declarations.h"
#include "core/env/check_writers.h"
#include "core/env/error_location.h"
#include "core/env/plugin_setup_tables.h"
#include "core/env/scenario_layout.h"
#include "core/env/scenario_model.h"
#include "core/model/located_error.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/coupling/coupling_start.h"
#include "core/physics/world/world_layout.h"
#include "core/plugin_abi/path_pattern.h"

namespace skybody {
namespace {

/// A plugin use with its values as C structures.
struct BoundUse {
  BoundUse(const PluginUse& u, SkybodyKind k, std::vector<int> robots, std::string p)
      : use(&u), kind(k), team(std::move(robots)), path(std::move(p)), values(u.parameters) {}
  const PluginUse* use;
  SkybodyKind kind;
  std::vector<int> team;  ///< controllers: robots that they serve
  std::string path;       ///< of its parameters, such as robots.quad.controllers.rate_pd
  BoundValues values;
};

/// Configures the plugins of a scenario in order, each with the numbering of those before it.
struct Builder {
  ScenarioModel& model;
  PluginFactory& factory;
  const Topology topology;
  const Scenario& scenario = topology.scenario;
  WorldPlan plan;
  std::vector<BoundUse> uses;
  int offered_count = 0;                  ///< values that sensors so far read from effects
  std::vector<std::string> unset_params;  ///< would be randomizable if the scenario set them

  Builder(ScenarioModel& m, Scenario s, PluginFactory& f)
      : model(m), factory(f), topology(std::move(s)), plan(topology) {}

  void build() {
    collect_uses();
    model.starts = InitialStates(topology, plan.layout);
    for (BoundUse& use : uses) add_params(use);
    SetupTables tables(topology, plan.layout);
    configure_kind(SKYBODY_SENSOR, tables);
    configure_kind(SKYBODY_CONTROLLER, tables);
    connect(tables);
    configure_kind(SKYBODY_EFFECT, tables);
    configure_kind(SKYBODY_RANDOMIZER, tables);
    configure_kind(SKYBODY_TASK, tables);
    check_writers({model.plugins[SKYBODY_RANDOMIZER], model.task(), model.task_params, model.starts,
                   plan.layout, scenario});
    check_interpolation();
    list_actions();
    lay_out_scenario(model, topology, std::move(plan));
  }

  void collect_uses() {
    const std::vector<int> none;
    for (const PluginUse& use : scenario.sensors) {
      uses.emplace_back(use, SKYBODY_SENSOR, none, "sensors." + use.instance);
    }
    for (int r = 0; r < static_cast<int>(scenario.robots.size()); ++r) {
      const RobotUse& robot = scenario.robots[static_cast<std::size_t>(r)];
      for (const PluginUse& use : robot.controllers) {
        uses.emplace_back(use, SKYBODY_CONTROLLER, std::vector<int>{r},
                          "robots." + robot.name + ".controllers." + use.instance);
      }
    }
    for (const TeamUse& team : scenario.teams) {
      for (const PluginUse& use : team.controllers) {
        uses.emplace_back(use, SKYBODY_CONTROLLER, team.robots,
                          "teams." + team.name + ".controllers." + use.instance);
      }
    }
    for (const PluginUse& use : scenario.effects) {
      uses.emplace_back(use, SKYBODY_EFFECT, none, "effects." + use.instance);
    }
    for (const PluginUse& use : scenario.randomization) {
      uses.emplace_back(use, SKYBODY_RANDOMIZER, none, "randomization." + use.instance);
    }
    uses.emplace_back(scenario.task, SKYBODY_TASK, none, "task");
  }

  /// Adds randomizable parameters as EnvParams.
  void add_params(BoundUse& bound) {
    const int first = static_cast<int>(plan.layout.param_info.size());
    const std::vector<ParameterSpec>& specs = factory.parameters(bound.kind, bound.use->plugin);
    const std::vector<ParameterValue>& values = bound.use->parameters;
    SKYBODY_DEMAND(specs.size() == values.size(), "parameters of another plugin");
    for (std::size_t i = 0; i < specs.size(); ++i) {
      if (!specs[i].randomizable || values[i].numbers.empty()) continue;
      if (specs[i].when_given && !values[i].is_given) {
        unset_params.push_back(bound.path + "." + specs[i].name);
        continue;
      }
      bound.values.set_env_param(i, static_cast<int>(plan.layout.param_info.size()));
      add_env_params(bound.path + "." + specs[i].name, values[i].numbers, specs[i]);
    }
    if (bound.kind != SKYBODY_TASK) return;
    model.task_params = {first, static_cast<int>(plan.layout.param_info.size()) - first};
  }

  void add_env_params(const std::string& path, const std::vector<double>& numbers,
                      const ParameterSpec& spec) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::string name = numbers.size() == 1 ? path : path + "[" + std::to_string(i) + "]";
      add_param(plan.layout, {name, unit_of(spec.unit, i + 1 == numbers.size()), numbers[i],
                              spec.min, spec.max});
    }
  }

  /// The unit of one value of a vector: with "m, rad", the last value has radians, the others
  /// metres.
  static std::string unit_of(const std::string& units, bool is_last) {
    const std::size_t comma = units.find(", ");
    if (comma == units.npos) return units;
    return is_last ? units.substr(comma + 2) : units.substr(0, comma);
  }

  void configure_kind(SkybodyKind kind, SetupTables& tables) {
    for (const BoundUse& bound : uses) {
      if (bound.kind != kind) continue;
      PluginInstance made = configure(bound, tables);
      model.needs_bodies_before |= made.needs_bodies_before;
      model.needs_contacts |= made.needs_contacts;
      append(made.contact_pairs, model.contact_pairs);
      append(made.joint_reactions, model.joint_reactions);
      model.scratch_size = std::max(model.scratch_size, made.memory.scratch);
      model.scratch_block_size = std::max(model.scratch_block_size, made.memory.scratch_block);
      model.signal_size = std::max(model.signal_size, made.controller.output_count());
      if (kind == SKYBODY_SENSOR) {
        made.sensor.output = plan.layout.sensors.size;
        plan.layout.sensors.size += made.channel_count();
        made.sensor.images = static_cast<int>(8 * model.image_words);
        model.image_words += static_cast<std::size_t>(image_bytes(made.channels)) / 8;
        offered_count += made.sensor.requested();
        tables.add_sensor(made);
      }
      model.plugins[kind].push_back(std::move(made));
    }
  }

  template <class T>
  static void append(const std::vector<T>& more, std::vector<T>& all) {
    all.insert(all.end(), more.begin(), more.end());
  }

  PluginInstance configure(const BoundUse& bound, const SetupTables& tables) {
    PluginInstance made;
    made.kind = bound.kind;
    made.name = bound.use->instance;
    made.plugin = bound.use->plugin;
    made.controller.team = bound.team;
    made.memory.first_contact_pair = static_cast<int>(model.contact_pairs.size());
    made.memory.first_joint_reaction = static_cast<int>(model.joint_reactions.size());
    made.memory.first_offered = offered_count;
    made.mark = bound.use->mark;
    const SkybodyDeclare declare = declare_into(made);
    const SkybodySetup setup = tables.setup(bound.path, bound.team, bound.values.table());
    try {
      PluginFactory::Made result = factory.make(bound.kind, bound.use->plugin, setup, declare);
      made.self = std::move(result.self);
      made.kernels = result.kernels;
      made.dual_kernels = result.dual_kernels;
      made.memory.state_words = result.state_words;
      made.file = result.file;
      check_declarations(topology, plan.layout, made);
    } catch (const Error& e) {
      throw LocatedError(blamed(scenario, *bound.use, e.what()),
                         with_nearest_param(plan.layout, with_unset_param(e.what())));
    }
    return made;
  }

  /// Adds the remedy to a message about a parameter that has its default.
  std::string with_unset_param(const std::string& message) const {
    for (const std::string& path : unset_params) {
      const std::size_t found = message.find("called `" + path + "`");
      if (found == std::string::npos) continue;
      const std::string name = path.substr(path.rfind('.') + 1);
      return message.substr(0, message.find(plugin_detail::kNoSuchParam)) + ": `" + name +
             "` has its default; set it in the scenario, and it can be drawn";
    }
    return message;
  }

  void connect(SetupTables& tables) {
    model.chains = connect_controllers(scenario, model.plugins[SKYBODY_CONTROLLER], plan);
    for (const ControllerChain& chain : model.chains) {
      if (!chain.is_fed) model.commanded += chain.inputs;
    }
    tables.set_chains(model.chains);
  }

  /// Rejects interpolation of quaternions: interpolating their values one by one gives no rotation.
  void check_interpolation() const {
    if (!model.task().task.interpolates) return;
    for (const ControllerChain& chain : model.chains) {
      const bool has_quaternion = chain.signal == SKYBODY_ATTITUDE || chain.signal == SKYBODY_POSE;
      if (chain.is_fed || !has_quaternion) continue;
      throw LocatedError(scenario.task.mark, "task `" + model.task().plugin +
                                                 "` changes commands in equal parts, which " +
                                                 signal_name(chain.signal) +
                                                 " does not allow: it has a quaternion");
    }
  }

  /// The action row: the task's own, or the chains' commands.
  void list_actions() {
    int& size = plan.layout.action.size;
    const auto add = [&](ActionChannel channel) {
      channel.first = size;
      size += static_cast<int>(channel.low.size());
      const bool decides = !channel.low.empty();  // false: the chain begins with a reference
      if (decides && (model.agents.empty() || model.agents.back() != channel.robot)) {
        model.agents.push_back(channel.robot);
      }
      model.action_channels.push_back(std::move(channel));
    };
    const auto repeated = [](double value, int count) {
      return std::vector<double>(static_cast<std::size_t>(count), value);
    };
    for (const Channel& c : model.task().task.actions) {
      add({c.name, c.unit, c.robot, 0, repeated(c.low, c.count), repeated(c.high, c.count)});
    }
    if (size > 0) return;
    for (const ControllerChain& chain : model.chains) {
      if (chain.is_fed) continue;
      const PluginInstance& first =
          model.plugins[SKYBODY_CONTROLLER][static_cast<std::size_t>(chain.first)];
      add({signal_name(chain.signal), "", chain.robot, 0, first.controller.low,
           first.controller.high});
    }
  }
};

/// The state words that draws change, and the starts that belong to them.
void list_drawn_words(ScenarioModel& model) {
  const StateLayout& l = model.layout();
  for (PluginInstance& r : model.plugins[SKYBODY_RANDOMIZER]) {
    r.randomizer.starts = model.starts.places_of(r.writes);
    for (int k = r.memory.state; k < r.memory.state + r.memory.state_words + r.memory.buffer_words;
         ++k) {
      model.drawn_words.push_back(l.plugin_state.offset + k);
    }
    for (const int param : r.writes) model.drawn_words.push_back(l.params.offset + param);
  }
}

}  // namespace

std::unique_ptr<const ScenarioModel> build_scenario_model(Scenario scenario, PluginFactory& factory,
                                                          Checking checking) {
  auto model = std::make_unique<ScenarioModel>();
  model->is_checked = checking == Checking::kYes;
  Builder(*model, std::move(scenario), factory).build();
  check_driven_ends(*model->world);
  write_default_state(*model->world, model->nominal);
  model->physics = std::make_unique<const GroupPhysics>(*model->world);
  list_drawn_words(*model);
  return model;
}

}  // namespace skybody
