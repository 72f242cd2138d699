#include "core/env/scenario_model.h"

#include <algorithm>

#include "core/base/system/error.h"
#include "core/env/group_workspace.h"
#include "core/env/row_conversion.h"
#include "core/physics/world/lane_values.h"

namespace skybody {
namespace {

/// The numbers of values that plugins may touch.
SkybodyChecks make_checks(const ScenarioModel& model) {
  const StateLayout& l = model.layout();
  SkybodyChecks checks{};
  checks.bodies = static_cast<int>(model.world->bodies.size());
  checks.rotors = static_cast<int>(model.world->rotors.size());
  checks.robots =
      model.task().task.robot_rewards ? static_cast<int>(model.scenario().robots.size()) : 0;
  checks.q = l.q.size;
  checks.u = l.u.size;
  checks.params = l.params.size;
  checks.sensors = l.sensors.size;
  checks.action = l.action.size;
  checks.command = l.command.size;
  return checks;
}

/// The greatest number of values that a randomizer writes during an episode.
std::size_t most_drawn_in_time(const ScenarioModel& model) {
  std::size_t most = 0;
  for (const PluginInstance& r : model.of(SKYBODY_RANDOMIZER)) {
    if (r.randomizer.draws_in_time) most = std::max(most, r.writes.size());
  }
  return most;
}

}  // namespace

std::uint32_t due(const PluginInstance& plugin, const StateGroup& group, std::uint32_t mask) {
  if (plugin.period <= 1) return mask;
  return row_kernels().multiples(mask, group.bits(kPhysicsStep),
                                 static_cast<double>(plugin.period));
}

bool is_left_out(const PluginInstance& sensor, std::int64_t steps_left) {
  return sensor.sensor.is_only_when_read &&
         std::max(sensor.period, 1) <= steps_left % SKYBODY_LONGEST_LEFT_OUT;
}

bool ScenarioModel::checks_starts() const {
  return scenario().contact.redraws > 0 && count_bristles(*world) > 0;
}

Block ScenarioModel::commands_of(int robot) const {
  Block commands{layout().command.offset, 0};
  for (const ControllerChain& chain : chains) {
    if (chain.is_fed) break;  // commands of fed chains come after those of action and task
    if (chain.robot < robot) commands.offset += chain.inputs;
    if (chain.robot == robot) commands.size += chain.inputs;
  }
  return commands;
}

SkybodyLanes ScenarioModel::view(const StateGroup& group, GroupWorkspace& work,
                                 std::uint32_t mask) const {
  const StateLayout& l = layout();
  SkybodyLanes v{};
  v.lanes = static_cast<std::uint32_t>(group.lanes());
  v.active = mask;
  v.key = group.bits(kSeed);
  v.episode = group.bits(kEpisode);
  v.step = group.bits(kStep);
  v.physics_step = group.bits(kPhysicsStep);
  v.bodies = group.bodies();
  v.bodies_before = l.bodies_before.size > 0 ? group.reals(l.bodies_before) : nullptr;
  v.q = group.reals(l.q);
  v.u = group.reals(l.u);
  v.rotor_speed = group.reals(l.rotor_speed);
  v.rotor_command = group.reals(l.rotor_command);
  v.params = group.reals(l.params);
  v.sensors = group.reals(l.sensors);
  v.action = group.reals(l.action);
  v.command = group.reals(l.command);
  v.contacts = needs_contacts ? group.reals(l.contacts) : nullptr;
  v.contact_pairs = contact_pairs.empty() ? nullptr : group.reals(l.contact_pairs);
  v.joint_reactions = joint_reactions.empty() ? nullptr : group.reals(l.joint_reactions);
  v.plugin_words = offered.empty() ? nullptr : group.reals(l.plugin_state);
  v.offered = offered.data();
  v.scratch = work.scratch.data();
  v.checks = is_checked ? &work.checks : nullptr;
  return v;
}

StateGroup ScenarioModel::make_state(int lanes) const {
  SKYBODY_DEMAND(lanes == 1 || lanes == kGroupLanes, "a group has one lane or kGroupLanes");
  const int bodies = physics->bodies_are_coordinates() ? 0 : static_cast<int>(world->bodies.size());
  return {layout(), bodies, lanes, static_cast<int>(image_words), physics->make_stepper(lanes)};
}

std::unique_ptr<GroupWorkspace> ScenarioModel::make_workspace(int lanes) const {
  constexpr std::size_t kFewContacts = 64;
  const auto n = static_cast<std::size_t>(lanes);
  const auto values = [n](auto count) {
    return AlignedArray<double>(static_cast<std::size_t>(count) * n);
  };
  auto work = std::make_unique<GroupWorkspace>();
  work->lanes = lanes;
  work->requests.resize(n);
  work->checks = make_checks(*this);
  work->physics = physics->make_scratch();
  work->scratch = AlignedArray<double>(std::max(static_cast<std::size_t>(scratch_size) * n,
                                                static_cast<std::size_t>(scratch_block_size)));
  if (checks_starts() || senses_contacts()) work->contacts.reserve(kFewContacts);
  work->image_rows.resize(observation.images.size());

  ControlScratch& control = work->control;
  for (auto& signal : control.signal) signal = values(signal_size);
  control.action = values(task().task.actions.empty() ? 0 : layout().action.size);
  const int moving = task().task.interpolates ? commanded : 0;
  control.command_from = values(moving);
  control.command_to = values(moving);

  TaskOutcome& outcome = work->outcome;
  outcome.observation = values(observation.size());
  if (!observation.is_task_in_place) outcome.task_values = values(task().channel_count());
  outcome.reward = values(1);
  outcome.robot_reward = values(scenario().robots.size());
  outcome.agent_reward = values(agents.size());
  outcome.info = values(value_count(info_channels));
  outcome.end = AlignedArray<std::uint64_t>(n);

  DrawScratch& draws = work->draws;
  draws.in_time = values(most_drawn_in_time(*this));
  draws.undrawn = AlignedArray<std::uint64_t>(drawn_words.size() * n);
  draws.number = AlignedArray<std::uint64_t>(n);
  work->faults.start_status = AlignedArray<std::uint64_t>(n);
  return work;
}

}  // namespace skybody
