// Builds a CompiledScenario: adds parameters of plugins to the state words, configures plugins,
// checks signals, and places every block.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/system/error.h"
#include "core/env/check_declarations.h"
#include "core/env/check_writers.h"
#include "core/env/compiled_scenario.h"
#include "core/env/error_location.h"
#include "core/env/group_workspace.h"
#include "core/env/param_access.h"
#include "core/env/plugin_setup_tables.h"
#include "core/env/start_overlaps.h"
#include "core/env/state_values.h"
#include "core/model/located_error.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/coupling/coupling_start.h"
#include "core/physics/world/lane_values.h"
#include "core/physics/world/world_layout.h"

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

}  // namespace

struct CompiledScenario::Builder {
  CompiledScenario& env;
  PluginFactory& factory;
  const Topology topology;
  const Scenario& scenario = topology.scenario;
  WorldPlan plan;
  std::vector<BoundUse> uses;

  Builder(CompiledScenario& e, Scenario s, PluginFactory& f)
      : env(e), factory(f), topology(std::move(s)), plan(topology) {}

  void build() {
    collect_uses();
    env.starts_ = InitialStates(topology, plan.layout);
    for (BoundUse& use : uses) add_params(use);
    SetupTables tables(topology, plan.layout);
    configure_kind(SKYBODY_SENSOR, tables);
    configure_kind(SKYBODY_CONTROLLER, tables);
    connect(tables);
    configure_kind(SKYBODY_EFFECT, tables);
    configure_kind(SKYBODY_RANDOMIZER, tables);
    configure_kind(SKYBODY_TASK, tables);
    check_writers({env.plugins_[SKYBODY_RANDOMIZER], env.task(), env.task_params_, env.starts_,
                   plan.layout, scenario});
    check_interpolation();
    list_actions();
    lay_out();
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
      bound.values.set_env_param(i, static_cast<int>(plan.layout.param_info.size()));
      add_env_params(bound.path + "." + specs[i].name, values[i].numbers, specs[i]);
    }
    if (bound.kind != SKYBODY_TASK) return;
    env.task_params_ = {first, static_cast<int>(plan.layout.param_info.size()) - first};
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
      env.needs_bodies_before_ |= made.needs_bodies_before;
      env.needs_contacts_ |= made.needs_contacts;
      env.draws_in_time_ |= made.draws_in_time;
      append(made.contact_pairs, env.contact_pairs_);
      append(made.joint_reactions, env.joint_reactions_);
      env.scratch_size_ = std::max(env.scratch_size_, made.scratch);
      env.signal_size_ = std::max(env.signal_size_, made.output_count());
      if (kind == SKYBODY_SENSOR) {
        made.output = plan.layout.sensors.size;
        plan.layout.sensors.size += made.channel_count();
        made.images = static_cast<int>(8 * env.image_words_);
        env.image_words_ += static_cast<std::size_t>(image_bytes(made.channels)) / 8;
        tables.add_sensor(made);
      }
      env.plugins_[kind].push_back(std::move(made));
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
    made.team = bound.team;
    made.first_contact_pair = static_cast<int>(env.contact_pairs_.size());
    made.first_joint_reaction = static_cast<int>(env.joint_reactions_.size());
    made.mark = bound.use->mark;
    const SkybodyDeclare declare = declare_into(made);
    const SkybodySetup setup = tables.setup(bound.path, bound.team, bound.values.table());
    try {
      PluginFactory::Made result = factory.make(bound.kind, bound.use->plugin, setup, declare);
      made.self = std::move(result.self);
      made.kernels = result.kernels;
      made.dual_kernels = result.dual_kernels;
      made.state_words = result.state_words;
      made.file = result.file;
      check_declarations(topology, plan.layout, made);
    } catch (const Error& e) {
      throw LocatedError(blamed(scenario, *bound.use, e.what()),
                         with_nearest_param(plan.layout, e.what()));
    }
    return made;
  }

  void connect(SetupTables& tables) {
    env.chains_ = connect_controllers(scenario, env.plugins_[SKYBODY_CONTROLLER], plan);
    for (const ControllerChain& chain : env.chains_) {
      if (!chain.is_fed) env.commanded_ += chain.inputs;
    }
    tables.set_chains(env.chains_);
  }

  /// Rejects interpolation of quaternions: interpolating their values one by one gives no rotation.
  void check_interpolation() const {
    if (!env.task().interpolates) return;
    for (const ControllerChain& chain : env.chains_) {
      const bool has_quaternion = chain.signal == SKYBODY_ATTITUDE || chain.signal == SKYBODY_POSE;
      if (chain.is_fed || !has_quaternion) continue;
      throw LocatedError(scenario.task.mark, "task `" + env.task().plugin +
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
      if (decides && (env.agents_.empty() || env.agents_.back() != channel.robot)) {
        env.agents_.push_back(channel.robot);
      }
      env.action_channels_.push_back(std::move(channel));
    };
    const auto repeated = [](double value, int count) {
      return std::vector<double>(static_cast<std::size_t>(count), value);
    };
    for (const Channel& c : env.task().actions) {
      add({c.name, c.unit, c.robot, 0, repeated(c.low, c.count), repeated(c.high, c.count)});
    }
    if (size > 0) return;
    for (const ControllerChain& chain : env.chains_) {
      if (chain.is_fed) continue;
      const PluginInstance& first =
          env.plugins_[SKYBODY_CONTROLLER][static_cast<std::size_t>(chain.first)];
      add({signal_name(chain.signal), "", chain.robot, 0, first.low, first.high});
    }
  }

  void lay_out() {
    StateLayout& l = plan.layout;
    l.bodies_before.size =
        env.needs_bodies_before_ ? 13 * static_cast<int>(topology.bodies.size()) : 0;
    l.contacts.size =
        env.needs_contacts_ ? SKYBODY_CONTACT_VALUES * static_cast<int>(topology.bodies.size()) : 0;
    l.contact_pairs.size = SKYBODY_CONTACT_VALUES * static_cast<int>(env.contact_pairs_.size());
    l.joint_reactions.size =
        SKYBODY_REACTION_VALUES * static_cast<int>(env.joint_reactions_.size());
    env.plan_ = plan_observation(env.task(), env.plugins_[SKYBODY_SENSOR], scenario.observe);
    l.last_observation.size = env.plan_.size();
    for (auto& list : env.plugins_) {
      for (PluginInstance& p : list) {
        for (std::size_t i = 0; i < p.holds.size(); ++i) plan.holds[i] |= p.holds[i];
        place_state(p, l.plugin_state.size);
        p.first_memo = l.memo;
        l.memo += p.memo;
      }
    }
    find_readers();
    list_infos();
    place_outputs(l.plugin_state.size);
    place_held(l.plugin_state.size);
    env.world_ = std::make_unique<const World>(topology, std::move(plan));
    make_absolute();
  }

  /// Finds the sensors that other plugins read in every physics step: these are called in every
  /// step.
  void find_readers() {
    for (PluginInstance& sensor : env.plugins_[SKYBODY_SENSOR]) {
      const auto is_of_sensor = [&](int first) {
        return first >= sensor.output && first < sensor.output + sensor.channel_count();
      };
      for (const auto& list : env.plugins_) {
        for (const PluginInstance& p : list) {
          const bool is_called_between = p.kind == SKYBODY_CONTROLLER || p.kind == SKYBODY_EFFECT ||
                                         p.kind == SKYBODY_SENSOR ||
                                         (p.kind == SKYBODY_TASK && p.period > 0);
          if (is_called_between && std::any_of(p.reads.begin(), p.reads.end(), is_of_sensor)) {
            sensor.is_only_when_read = false;
          }
        }
      }
    }
  }

  void list_infos() {
    env.info_channels_ = env.task().infos;
    for (const auto& list : env.plugins_) {
      for (const PluginInstance& p : list) {
        for (const Report& report : p.reports) {
          env.info_channels_.push_back(report.info);
          env.info_channels_.back().name = p.name + "." + report.info.name;
        }
      }
    }
    for (const std::string& path : scenario.infos.paths) add_param_infos(path);
  }

  /// Reports randomizable values that the scenario names.
  void add_param_infos(const std::string& path) {
    try {
      for (const int param : find_params(scenario, plan.layout, path)) {
        const auto& all = env.info_params_;
        if (std::find(all.begin(), all.end(), param) != all.end()) {
          throw Error("`" + path + "` names " +
                      plan.layout.param_info[static_cast<std::size_t>(param)].path +
                      " a second time: name each value once");
        }
        const EnvParam& info = plan.layout.param_info[static_cast<std::size_t>(param)];
        env.info_params_.push_back(param);
        env.info_channels_.push_back({info.path, info.unit, 1, info.min, info.max});
      }
    } catch (const Error& error) {
      throw LocatedError(scenario.infos.mark, "`infos`: " + std::string(error.what()));
    }
  }

  static void place_state(PluginInstance& p, int& next) {
    p.state = next;
    p.buffer = next + p.state_words;
    next += p.state_words + p.buffer_words;
  }

  /// Places the last outputs of controllers that others follow and that are not called in every
  /// physics step.
  void place_outputs(int& next) {
    for (const ControllerChain& chain : env.chains_) {
      for (int i = chain.first; i + 1 < chain.first + chain.count; ++i) {
        PluginInstance& c = env.plugins_[SKYBODY_CONTROLLER][static_cast<std::size_t>(i)];
        if (c.period <= 1) continue;
        c.last_output = {next, c.output_count()};
        next += c.last_output.size;
      }
    }
  }

  /// If several effects contribute to one input, each gets words of its own.
  void place_held(int& next) {
    for (std::size_t i = 0; i < plan.holds.size(); ++i) {
      std::vector<PluginInstance*> holders;
      for (PluginInstance& e : env.plugins_[SKYBODY_EFFECT]) {
        if (e.holds[i]) holders.push_back(&e);
      }
      if (holders.size() < 2) continue;
      for (PluginInstance* e : holders) {
        e->held[i] = {next, held_size(plan, static_cast<int>(i))};
        next += e->held[i].size;
      }
    }
  }

  /// Converts places within plugin_state to places within all words.
  void make_absolute() {
    const StateLayout& l = env.layout();
    for (PluginInstance& c : env.plugins_[SKYBODY_CONTROLLER]) {
      c.last_output.offset += l.plugin_state.offset;
    }
    for (PluginInstance& e : env.plugins_[SKYBODY_EFFECT]) {
      for (std::size_t i = 0; i < e.held.size(); ++i) {
        if (e.held[i].size > 0) {
          e.held[i].offset += l.plugin_state.offset;
        } else if (e.holds[i]) {
          e.held[i] = l.held[i];
        }
      }
    }
  }
};

CompiledScenario::CompiledScenario(Scenario scenario, PluginFactory& factory, Checking checking)
    : is_checked_(checking == Checking::kYes) {
  Builder(*this, std::move(scenario), factory).build();
  check_driven_ends(*world_);
  write_default_state(*world_, initial_);
  for (PluginInstance& r : plugins_[SKYBODY_RANDOMIZER]) r.starts = starts_.places_of(r.writes);
  draws_bodies_ = draws_bodies();
  physics_ = std::make_unique<const GroupPhysics>(*world_);
  state_values_ = std::make_unique<const StateValues>(*this);
  look_for_bad_starts();
}

CompiledScenario::~CompiledScenario() = default;

Block CompiledScenario::commands_of(int robot) const {
  Block commands{layout().command.offset, 0};
  for (const ControllerChain& chain : chains_) {
    if (chain.is_fed) break;  // commands of fed chains come after those of action and task
    if (chain.robot < robot) commands.offset += chain.inputs;
    if (chain.robot == robot) commands.size += chain.inputs;
  }
  return commands;
}

StateGroup CompiledScenario::make_state(int lanes) const {
  SKYBODY_DEMAND(lanes == 1 || lanes == kGroupLanes, "a group has one lane or kGroupLanes");
  const int bodies =
      physics_->bodies_are_coordinates() ? 0 : static_cast<int>(world_->bodies.size());
  return {layout(), bodies, lanes, static_cast<int>(image_words_), physics_->make_stepper(lanes)};
}

/// The numbers of values that plugins may touch.
SkybodyChecks CompiledScenario::make_checks() const {
  SkybodyChecks checks{};
  checks.bodies = static_cast<int>(world_->bodies.size());
  checks.rotors = static_cast<int>(world_->rotors.size());
  checks.robots = task().robot_rewards ? static_cast<int>(scenario().robots.size()) : 0;
  checks.q = layout().q.size;
  checks.u = layout().u.size;
  checks.params = layout().params.size;
  checks.sensors = layout().sensors.size;
  checks.action = layout().action.size;
  checks.command = layout().command.size;
  return checks;
}

std::unique_ptr<GroupWorkspace> CompiledScenario::make_workspace(int lanes) const {
  constexpr std::size_t kFewContacts = 64;
  auto work = std::make_unique<GroupWorkspace>();
  const auto n = static_cast<std::size_t>(lanes);
  const auto values = [n](std::size_t count) { return AlignedArray<double>(count * n); };
  work->lanes = lanes;
  work->requests.resize(static_cast<std::size_t>(lanes));
  work->is_checked = is_checked_;
  work->checks = make_checks();
  work->physics = physics_->make_scratch();
  for (auto& signal : work->signal) signal = values(static_cast<std::size_t>(signal_size_));
  work->scratch = values(static_cast<std::size_t>(scratch_size_));
  work->action = values(static_cast<std::size_t>(task().actions.empty() ? 0 : action_size()));
  const int moving = task().interpolates ? commanded_ : 0;
  work->command_from = values(static_cast<std::size_t>(moving));
  work->command_to = values(static_cast<std::size_t>(moving));
  work->observation = values(static_cast<std::size_t>(plan_.size()));
  if (!plan_.is_task_in_place) {
    work->task_values = values(static_cast<std::size_t>(task().channel_count()));
  }
  std::size_t drawn = 0;
  for (const PluginInstance& r : plugins_[SKYBODY_RANDOMIZER]) {
    if (r.draws_in_time) drawn = std::max(drawn, r.writes.size());
  }
  work->drawn = values(drawn);
  work->reward = values(1);
  work->robot_reward = values(scenario().robots.size());
  work->agent_reward = values(agents_.size());
  work->info = values(static_cast<std::size_t>(info_size()));
  work->image_rows.resize(plan_.images.size());
  work->joint_reactions.resize(joint_reactions_.empty() ? 0 : world_->bodies.size());
  work->end = AlignedArray<std::uint64_t>(n);
  work->start_status = AlignedArray<std::uint64_t>(n);
  work->undrawn = AlignedArray<std::uint64_t>(drawn_words_.size() * n);
  if (start_overlaps_ != nullptr || senses_contacts()) work->contacts.reserve(kFewContacts);
  work->request = AlignedArray<std::uint64_t>(n);
  return work;
}

}  // namespace skybody
