#include "onboard/export_mission.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/base/math/hash.h"
#include "core/plugin_host/registry.h"

namespace skybody::onboard {
namespace {

/// A task's values with the names of their parameters and the contents of files.
std::vector<SetupValue> values_of(const SkybodySetup& setup,
                                  const std::vector<ParameterSpec>& specs) {
  std::vector<SetupValue> values;
  for (std::size_t k = 0; k < specs.size(); ++k) {
    const SkybodyValue& from = setup.values[k];
    SetupValue value;
    value.name = specs[k].name;
    value.env_param = from.env_param;
    value.is_given = from.is_given;
    if (specs[k].type == ParameterType::kText) {
      value.texts.assign(from.texts, from.texts + from.count);
    } else {
      value.numbers.assign(from.numbers, from.numbers + from.count);
    }
    if (specs[k].is_file) {
      for (const std::string& file : value.texts) {
        value.contents.push_back(file.empty() ? "" : read_file(file));
      }
    }
    values.push_back(std::move(value));
  }
  return values;
}

/// The entries of the action that an agent gives; of a policy for one robot all.
std::vector<int> entries_of(const PolicyFile& policy, int agent) {
  if (!policy.agents.empty()) return policy.agents[static_cast<std::size_t>(agent)].action;
  std::vector<int> all;
  for (int k = 0; k < policy.action_size; ++k) all.push_back(k);
  return all;
}

void set_actions(Mission& m, const CompiledScenario& compiled) {
  const std::vector<int> entries = entries_of(m.policy, m.agent);
  std::set<int> robots;
  for (const ActionChannel& c : compiled.action_channels()) {
    m.actions.push_back({c.name, c.robot, c.first, c.low, c.high});
    const bool is_own = std::find(entries.begin(), entries.end(), c.first) != entries.end();
    if (is_own && !c.low.empty()) robots.insert(c.robot);
  }
  if (robots.size() != 1) {
    throw Error("the policy commands " + std::to_string(robots.size()) +
                " robots at once: one vehicle flies a policy for one robot, or one that robots "
                "share");
  }
  m.robot = *robots.begin();
}

void set_observation(Mission& m, const CompiledScenario& compiled) {
  const ObservationPlan& plan = compiled.model().observation;
  m.is_task_in_place = plan.is_task_in_place;
  for (const ObservationPart& p : plan.parts) {
    m.parts.push_back({p.is_of_task, p.from, p.to, p.count});
  }
  const auto is_seen = [&m](int first) {
    if (m.policy.agents.empty()) return true;
    const auto& own = m.policy.agents[static_cast<std::size_t>(m.agent)].observation;
    return std::find(own.begin(), own.end(), first) != own.end();
  };
  for (const ObservationColumn& c : plan.columns) {
    if (c.privileged || c.image >= 0 || !is_seen(c.first)) continue;
    m.columns.push_back({c.name, c.unit, c.doc, c.first, c.count()});
  }
}

void check_fits(const PolicyFile& policy, int agent, const CompiledScenario& compiled) {
  if (policy.observation_size != compiled.observation_size() ||
      policy.action_size != compiled.action_size()) {
    throw Error("the policy has other sizes than `" + compiled.scenario().name +
                "`: give --scenario FILE, the one that it was trained in");
  }
  if (!policy.images.empty()) {
    throw Error("the policy sees images, which the program onboard does not take: export it to C");
  }
  if (agent >= static_cast<int>(std::max<std::size_t>(1, policy.agents.size()))) {
    throw Error("the policy is not shared by so many robots");
  }
}

}  // namespace

Mission make_mission(LoadOptions options, const PolicyFile& policy, int agent,
                     const Limits& limits) {
  const std::string task = compile_scenario(options)->task().plugin;
  const auto registry = find_plugins(options);
  const PluginEntry* entry = registry->find(SKYBODY_TASK, task);
  if (entry == nullptr) throw Error("the task `" + task + "` is not in a library of plugins");
  Mission made;
  options.on_setup = [&](SkybodyKind kind, const SkybodySetup& setup) {
    if (kind == SKYBODY_TASK) made.setup = SetupCopy(setup, values_of(setup, entry->parameters));
  };
  const auto compiled = compile_scenario(options);
  check_fits(policy, agent, *compiled);
  made.scenario = compiled->scenario().name;
  made.scenario_hash = to_hex(compiled->scenario().hash);
  made.task = task;
  made.task_version = entry->version;
  made.agent = agent;
  made.policy = policy;
  made.limits = limits;
  set_actions(made, *compiled);
  set_observation(made, *compiled);
  return made;
}

}  // namespace skybody::onboard
