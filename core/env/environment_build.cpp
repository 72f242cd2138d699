// Building an Environment: parameters of plugins join WorldState, plugins are configured, signals
// are checked, and every block gets its place.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/error.h"
#include "core/env/check_declarations.h"
#include "core/env/environment.h"
#include "core/env/group_work.h"
#include "core/env/setup_tables.h"
#include "core/model/marked_error.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/step/lane_values.h"
#include "core/physics/world/world_layout.h"

namespace skybody {
namespace {

/// A plugin use with its values in C form.
struct BoundUse {
  BoundUse(const PluginUse& u, SkybodyKind k, int r, std::string p)
      : use(&u), kind(k), robot(r), path(std::move(p)), values(u.parameters) {}
  const PluginUse* use;
  SkybodyKind kind;
  int robot;
  std::string path;  ///< of its parameters, such as robots.quad.controllers.rate_pd
  BoundValues values;
};

bool drives(int signal) { return signal == SKYBODY_VELOCITY || signal == SKYBODY_POSE; }

bool actuates(int signal) {
  return signal == SKYBODY_ROTOR_SPEED || signal == SKYBODY_WRENCH || drives(signal);
}

}  // namespace

struct Environment::Builder {
  Environment& env;
  PluginFactory& factory;
  const Topology topology;
  const Scenario& scenario = topology.scenario;
  WorldPlan plan;
  std::vector<BoundUse> uses;

  Builder(Environment& e, Scenario s, PluginFactory& f)
      : env(e), factory(f), topology(std::move(s)), plan(topology) {}

  void build() {
    collect_uses();
    for (BoundUse& use : uses) add_params(use);
    SetupTables tables(topology, plan.layout);
    configure_kind(SKYBODY_SENSOR, tables);
    configure_kind(SKYBODY_CONTROLLER, tables);
    connect_controllers(tables);
    configure_kind(SKYBODY_RANDOMIZER, tables);
    check_writers();
    configure_kind(SKYBODY_TASK, tables);
    lay_out();
  }

  void collect_uses() {
    for (const PluginUse& use : scenario.sensors) {
      uses.emplace_back(use, SKYBODY_SENSOR, -1, "sensors." + use.instance);
    }
    for (int r = 0; r < static_cast<int>(scenario.robots.size()); ++r) {
      const RobotUse& robot = scenario.robots[static_cast<std::size_t>(r)];
      for (const PluginUse& use : robot.controllers) {
        uses.emplace_back(use, SKYBODY_CONTROLLER, r,
                          "robots." + robot.name + ".controllers." + use.instance);
      }
    }
    for (const PluginUse& use : scenario.randomization) {
      uses.emplace_back(use, SKYBODY_RANDOMIZER, -1, "randomization." + use.instance);
    }
    uses.emplace_back(scenario.task, SKYBODY_TASK, -1, "task");
  }

  /// Randomizable parameters become EnvParams.
  void add_params(BoundUse& bound) {
    const std::vector<ParameterSpec>& specs = factory.parameters(bound.kind, bound.use->plugin);
    const std::vector<ParameterValue>& values = bound.use->parameters;
    SKYBODY_DEMAND(specs.size() == values.size(), "parameters of another plugin");
    for (std::size_t i = 0; i < specs.size(); ++i) {
      if (!specs[i].randomizable || values[i].numbers.empty()) continue;
      bound.values.set_env_param(i, static_cast<int>(plan.layout.param_info.size()));
      add_env_params(bound.path + "." + specs[i].name, values[i].numbers, specs[i]);
    }
  }

  void add_env_params(const std::string& path, const std::vector<double>& numbers,
                      const ParameterSpec& spec) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::string name = numbers.size() == 1 ? path : path + "[" + std::to_string(i) + "]";
      add_param(plan.layout, {name, spec.unit, numbers[i], spec.min, spec.max});
    }
  }

  void configure_kind(SkybodyKind kind, SetupTables& tables) {
    for (const BoundUse& bound : uses) {
      if (bound.kind != kind) continue;
      PluginInstance made = configure(bound, tables);
      env.needs_bodies_before_ |= made.needs_bodies_before;
      if (kind == SKYBODY_SENSOR) {
        made.output = plan.layout.sensors.size;
        plan.layout.sensors.size += made.channel_count();
        made.images = static_cast<int>(8 * env.image_words_);
        env.image_words_ += static_cast<std::size_t>(image_bytes(made.channels)) / 8;
        tables.add_sensor(made);
        env.sensors_.push_back(std::move(made));
      } else if (kind == SKYBODY_CONTROLLER) {
        env.controllers_.push_back(std::move(made));
      } else if (kind == SKYBODY_RANDOMIZER) {
        env.randomizers_.push_back(std::move(made));
      } else {
        env.task_ = std::move(made);
      }
    }
  }

  PluginInstance configure(const BoundUse& bound, const SetupTables& tables) {
    PluginInstance made;
    made.kind = bound.kind;
    made.name = bound.use->instance;
    made.plugin = bound.use->plugin;
    made.robot = bound.robot;
    const SkybodyDeclare declare = declare_into(made);
    const SkybodySetup setup = tables.setup(bound.path, bound.robot, bound.values.table());
    try {
      PluginFactory::Made result = factory.make(bound.kind, bound.use->plugin, setup, declare);
      made.self = std::move(result.self);
      made.kernels = result.kernels;
      made.state_words = result.state_words;
      check_declarations(topology, plan.layout, made);
    } catch (const Error& e) {
      throw MarkedError(bound.use->mark, e.what());
    }
    return made;
  }

  [[noreturn]] void refuse(int controller, const std::string& message) const {
    int i = 0;
    for (const BoundUse& bound : uses) {
      if (bound.kind == SKYBODY_CONTROLLER && i++ == controller) {
        throw MarkedError(bound.use->mark, message);
      }
    }
    throw MarkedError({scenario.file, 0, 0}, message);
  }

  /// Chains the controllers of each robot and gives commands, actions, sites and drives their
  /// places.
  void connect_controllers(SetupTables& tables) {
    int next = 0;
    for (int r = 0; r < static_cast<int>(scenario.robots.size()); ++r) {
      ControllerChain chain;
      chain.first = next;
      chain.count =
          static_cast<int>(scenario.robots[static_cast<std::size_t>(r)].controllers.size());
      chain.command = plan.layout.command.size;
      chain.action = plan.layout.action.size;
      chain.site = static_cast<int>(plan.sites.size());
      for (int i = 0; i < chain.count; ++i) check_link(chain, i);
      if (chain.count > 0) {
        add_chain(r, chain, tables);
        env.agents_.push_back(r);
      }
      env.chains_.push_back(chain);
      next += chain.count;
    }
  }

  void check_link(const ControllerChain& chain, int i) {
    const int index = chain.first + i;
    const PluginInstance& c = env.controllers_[static_cast<std::size_t>(index)];
    if (!c.sites.empty() && (i + 1 < chain.count || c.output_signal != SKYBODY_WRENCH)) {
      refuse(index, "controller `" + c.name +
                        "` declares wrench sites, but is not the last one or gives " +
                        signal_name(c.output_signal) + ": only the last one's wrench acts");
    }
    if (i + 1 == chain.count) {
      if (!actuates(c.output_signal)) {
        refuse(index, "the last controller, `" + c.name + "`, gives " +
                          signal_name(c.output_signal) +
                          "; it must give rotor_speed, wrench, velocity or pose: add a controller "
                          "behind it that takes " +
                          signal_name(c.output_signal));
      }
      check_actuator(index, c);
      return;
    }
    const PluginInstance& after = env.controllers_[static_cast<std::size_t>(index + 1)];
    if (after.input_signal != c.output_signal || after.input_count() != c.output_count) {
      refuse(index + 1, "controller `" + after.name + "` takes " + signal_name(after.input_signal) +
                            "[" + std::to_string(after.input_count()) + "], but `" + c.name +
                            "` before it gives " + signal_name(c.output_signal) + "[" +
                            std::to_string(c.output_count) + "]");
    }
  }

  void check_actuator(int index, const PluginInstance& c) {
    const int rotors = plan.layout.robots[static_cast<std::size_t>(c.robot)].rotor_count;
    const int expected = c.output_signal == SKYBODY_ROTOR_SPEED ? rotors
                         : c.output_signal == SKYBODY_WRENCH ? 6 * static_cast<int>(c.sites.size())
                         : c.output_signal == SKYBODY_VELOCITY ? 6
                                                               : 7;
    if (c.output_count != expected) {
      refuse(index, "controller `" + c.name + "` gives " + signal_name(c.output_signal) + "[" +
                        std::to_string(c.output_count) + "], this robot takes [" +
                        std::to_string(expected) + "]");
    }
    const RobotModel& model = scenario.robots[static_cast<std::size_t>(c.robot)].model;
    if (drives(c.output_signal) && model.fixed_base) {
      refuse(index, "controller `" + c.name + "` drives the base, but robot `" +
                        scenario.robots[static_cast<std::size_t>(c.robot)].name +
                        "` has a fixed one");
    }
  }

  void add_chain(int robot, ControllerChain& chain, SetupTables& tables) {
    const PluginInstance& first = env.controllers_[static_cast<std::size_t>(chain.first)];
    const PluginInstance& last =
        env.controllers_[static_cast<std::size_t>(chain.first + chain.count - 1)];
    const int inputs = first.input_count();
    tables.set_command(robot, first.input_signal, chain.command, inputs, chain.action);
    plan.layout.command.size += inputs;
    plan.layout.action.size += inputs;
    for (const WrenchSite& site : last.sites) plan.sites.push_back(site);
    chain.drive = count_driven(plan.drives);
    if (last.output_signal == SKYBODY_VELOCITY) {
      plan.drives[static_cast<std::size_t>(robot)] = DriveKind::kVelocity;
    } else if (last.output_signal == SKYBODY_POSE) {
      plan.drives[static_cast<std::size_t>(robot)] = DriveKind::kPose;
    }
    for (int i = 0; i < chain.count; ++i) {
      const PluginInstance& c = env.controllers_[static_cast<std::size_t>(chain.first + i)];
      env.scratch_size_ = std::max(env.scratch_size_, c.output_count);
    }
  }

  void check_writers() const {
    std::map<int, const PluginInstance*> writers;
    for (std::size_t i = 0; i < env.randomizers_.size(); ++i) {
      for (const int param : env.randomizers_[i].writes) {
        const auto [it, fresh] = writers.emplace(param, &env.randomizers_[i]);
        if (!fresh && it->second != &env.randomizers_[i]) {
          throw MarkedError(scenario.randomization[i].mark,
                            "randomizers `" + it->second->name + "` and `" +
                                env.randomizers_[i].name + "` both draw " +
                                plan.layout.param_info[static_cast<std::size_t>(param)].path +
                                ": leave it to one of them");
        }
      }
    }
  }

  void lay_out() {
    Layout& l = plan.layout;
    l.bodies_before.size =
        env.needs_bodies_before_ ? 13 * static_cast<int>(topology.bodies.size()) : 0;
    env.plan_ = plan_observation(env.task_, env.sensors_, scenario.observe);
    env.info_size_ = value_count(env.task_.infos);
    l.last_observation.size = env.plan_.size();
    for_each_plugin([&](PluginInstance& p) { place_state(p, l.plugin_state.size); });
    env.world_ = std::make_unique<const World>(topology, std::move(plan));
  }

  template <class F>
  void for_each_plugin(F&& f) {
    for (auto* list : {&env.controllers_, &env.sensors_, &env.randomizers_}) {
      for (PluginInstance& p : *list) f(p);
    }
    f(env.task_);
  }

  static void place_state(PluginInstance& p, int& next) {
    p.state = next;
    p.buffer = next + p.state_words;
    next += p.state_words + p.buffer_words;
  }
};

Environment::Environment(Scenario scenario, PluginFactory& factory) {
  Builder(*this, std::move(scenario), factory).build();
  write_default_state(*world_, initial_);
  physics_ = std::make_unique<const GroupPhysics>(*world_);
}

Environment::~Environment() = default;

StateGroup Environment::make_state(int lanes) const {
  SKYBODY_DEMAND(lanes == 1 || lanes == kGroupLanes, "a group has one lane or kGroupLanes");
  const int bodies =
      physics_->bodies_are_coordinates() ? 0 : static_cast<int>(world_->bodies.size());
  return {layout(), bodies, lanes, static_cast<int>(image_words_), physics_->make_stepper(lanes)};
}

std::unique_ptr<GroupWork> Environment::make_work(int lanes) const {
  auto work = std::make_unique<GroupWork>();
  const auto n = static_cast<std::size_t>(lanes);
  const auto values = [n](std::size_t count) { return AlignedArray<double>(count * n); };
  work->lanes = lanes;
  work->physics = physics_->make_scratch();
  for (auto& signal : work->signal) signal = values(static_cast<std::size_t>(scratch_size_));
  work->observation = values(static_cast<std::size_t>(plan_.size()));
  if (!plan_.is_task_in_place) {
    work->task_values = values(static_cast<std::size_t>(task_.channel_count()));
  }
  work->reward = values(1);
  work->robot_reward = values(scenario().robots.size());
  work->agent_reward = values(agents_.size());
  work->info = values(static_cast<std::size_t>(info_size()));
  work->image_rows.resize(plan_.images.size());
  work->end = AlignedArray<std::uint64_t>(n);
  work->request = AlignedArray<std::uint64_t>(n);
  return work;
}

}  // namespace skybody
