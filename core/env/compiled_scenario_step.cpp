// One transition, phase by phase (paper eq. 3): update, act, K times (command, control, apply,
// advance, feel, sense), evaluate, conclude. "The way of an action" in docs/architecture.md
// describes each phase. Under direct control they are called one by one.
#include <algorithm>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"
#include "core/env/row_conversion.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

static_assert(kGroupLanes == SKYBODY_GROUP_LANES, "plugins are made for other groups");

void CompiledScenario::step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                            const float* actions, int action_stride, const Rows& rows) const {
  check(group, work, mask);
  work.clear_faults();
  group.refresh(mask, work.physics);
  const SkybodyLanes lanes = view(group, work, mask);
  apply_action(group, work, lanes, actions, action_stride);
  fly_action(group, work, lanes);
  count(group, kStep, mask);
  evaluate(group, work, lanes, rows.info != nullptr);
  finish_transition(group, work, mask, false, rows);
}

/// The physics steps of an action.
void CompiledScenario::fly_action(StateGroup& group, GroupWorkspace& work,
                                  SkybodyLanes lanes) const {
  const int steps = scenario().stepping.action_repeat;
  const int period = task().period > 0 ? task().period : steps;  // of the command
  for (int k = 0; k < steps && lanes.active != 0; ++k) {
    if (k % period == 0) make_command(group, work, lanes);
    if (task().interpolates) {
      move_command(group, work, lanes.active, k % period + 1, period, k < period);
    }
    physics_step(group, work, lanes, steps - 1 - k);
  }
}

/// One physics step. Lanes that fail are removed from the active lanes.
/// @param steps_left  physics steps after this one before the outputs are read by anything but
///   plugins
void CompiledScenario::physics_step(StateGroup& group, GroupWorkspace& work, SkybodyLanes& lanes,
                                    std::int64_t steps_left) const {
  if (draws_in_time_) draw_in_time(group, work, lanes);
  control(group, work, lanes);
  apply_effects(group, lanes);
  lanes.active = advance(group, work, lanes.active);
  sense(group, lanes, steps_left);
}

void CompiledScenario::check(const StateGroup& group, const GroupWorkspace& work,
                             std::uint32_t mask) const {
  SKYBODY_DEMAND(work.lanes == group.lanes(), "a work of another group size");
  SKYBODY_DEMAND(group.lanes() >= 32 || (mask >> group.lanes()) == 0, "a mask beyond the group");
}

SkybodyLanes CompiledScenario::view(const StateGroup& group, GroupWorkspace& work,
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
  v.contacts = needs_contacts_ ? group.reals(l.contacts) : nullptr;
  v.contact_pairs = contact_pairs_.empty() ? nullptr : group.reals(l.contact_pairs);
  v.joint_reactions = joint_reactions_.empty() ? nullptr : group.reals(l.joint_reactions);
  v.scratch = work.scratch.data();
  v.checks = work.is_checked ? &work.checks : nullptr;
  return v;
}

void CompiledScenario::update(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const {
  group.refresh(mask, work.physics);
}

/// P_i: clips the action. A row that is not finite keeps the last action and makes this transition
/// a fault.
void CompiledScenario::apply_action(StateGroup& group, GroupWorkspace& work,
                                    const SkybodyLanes& view, const float* actions,
                                    int action_stride) const {
  const Block& action = layout().action;
  work.bad_action = view.active & ~row_kernels().read_clipped_actions(
                                      view.active, group.lanes(), actions, action_stride,
                                      action.size, group.writable(action, view.active));
}

/// Converts the action to the command.
void CompiledScenario::make_command(StateGroup& group, GroupWorkspace& work,
                                    const SkybodyLanes& view) const {
  const StateLayout& l = layout();
  const auto values = static_cast<std::size_t>(commanded_ * group.lanes());
  if (task().interpolates) {
    std::copy_n(group.reals(l.command), values, work.command_from.data());
  }
  if (task().kernels.process != nullptr) {
    process(group, work, view);
  } else {
    scale_action(group, view.active, group.writable(l.command, view.active));
  }
  if (task().interpolates) std::copy_n(group.reals(l.command), values, work.command_to.data());
}

/// Scales from [-1, 1] to the physical ranges of the action's channels.
void CompiledScenario::scale_action(const StateGroup& group, std::uint32_t mask,
                                    double* out) const {
  const int lanes = group.lanes();
  const double* action = group.reals(layout().action);
  for (const ActionChannel& channel : action_channels_) {
    row_kernels().scale(mask, lanes, action + channel.first * lanes,
                        static_cast<int>(channel.low.size()), channel.low.data(),
                        channel.high.data(), out + channel.first * lanes);
  }
}

/// Interpolates the command from the last one to the present one. The first action of an episode
/// has no last command: its command applies at once.
/// @param step      1..steps
/// @param is_first  of the action
void CompiledScenario::move_command(StateGroup& group, const GroupWorkspace& work,
                                    std::uint32_t mask, int step, int steps, bool is_first) const {
  const Block& block = layout().command;
  const double share = static_cast<double>(step) / steps;
  const std::uint64_t* actions = group.bits(kStep);
  double* command = group.writable(block, mask);
  for (int k = 0; k < commanded_; ++k) {
    each_lane(mask, [&](int lane) {
      const auto at = static_cast<std::size_t>(k * group.lanes() + lane);
      const double from = work.command_from[at], to = work.command_to[at];
      const bool is_there = step == steps || (is_first && actions[lane] == 0);
      command[at] = is_there ? to : from + share * (to - from);
    });
  }
}

/// Calls the task's process(), which computes the command. A task with its own action gets its
/// physical values.
void CompiledScenario::process(StateGroup& group, GroupWorkspace& work,
                               const SkybodyLanes& view) const {
  const bool has_own = !task().actions.empty();
  if (has_own) scale_action(group, view.active, work.action.data());
  const double* action = has_own ? work.action.data() : view.action;
  call_plugin(
      task().kernels.process, task(), group, view,
      [&] {
        return CallSizes{action_size(), commanded_, 0, "command",
                         group.writable(layout().command, view.active)};
      },
      action, group.writable(layout().command, view.active));
}

/// The lanes in which a plugin with a period is called before or after this physics step.
std::uint32_t CompiledScenario::due(const PluginInstance& plugin, const StateGroup& group,
                                    std::uint32_t mask) const {
  if (plugin.period <= 1) return mask;
  return row_kernels().multiples(mask, group.bits(kPhysicsStep),
                                 static_cast<double>(plugin.period));
}

/// C_i: every chain's controllers in order, from the latest state.
void CompiledScenario::control(StateGroup& group, GroupWorkspace& work,
                               const SkybodyLanes& view) const {
  for (const ControllerChain& chain : chains_) control(group, work, view, chain);
}

void CompiledScenario::control(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                               const ControllerChain& chain) const {
  const int lanes = group.lanes();
  const double* input = group.reals(layout().command) + chain.command * lanes;
  for (int i = 0; i < chain.count; ++i) {
    const PluginInstance& c =
        plugins_[SKYBODY_CONTROLLER][static_cast<std::size_t>(chain.first + i)];
    const bool is_last = i + 1 == chain.count;
    SkybodyLanes v = view;
    v.active = due(c, group, view.active);
    double* const scratch = work.signal[i & 1].data();
    double* const held = c.last_output.size > 0 ? group.writable(c.last_output, v.active) : nullptr;
    const ChainEnd& end = chain.ends[0];
    double* const target =
        is_last ? group.writable(layout().*end.block, v.active) + end.first * lanes : held;
    // If all lanes are written at once, write to the target directly; else keep the other lanes'
    // values.
    const bool is_direct = is_last && chain.ends.size() == 1 && v.active == group.occupied();
    double* const output = is_direct ? target : scratch;
    if (v.active != 0) {
      call_plugin(
          c.kernels.control, c, group, v,
          [&] {
            return CallSizes{c.input_count(), c.output_count(), 0, "output", output};
          },
          input, output);
    }
    input = held != nullptr ? held : output;
    if (is_direct) continue;
    if (is_last) {
      const double* from = scratch;
      for (const ChainEnd& e : chain.ends) {
        keep(group, v.active, e.count, from,
             group.writable(layout().*e.block, v.active) + e.first * lanes);
        from += e.count * lanes;
      }
    } else if (held != nullptr) {
      keep(group, v.active, c.last_output.size, scratch, held);
    }
  }
}

/// x_{k-1} -> x_k with the command held. Lanes whose physics fails keep their last finite state.
/// @returns the lanes that succeeded
std::uint32_t CompiledScenario::advance(StateGroup& group, GroupWorkspace& work,
                                        std::uint32_t mask) const {
  remember_bodies(group, mask);
  const std::uint32_t through = group.advance(mask, work.physics);
  work.bad_state |= mask & ~through;
  count(group, kPhysicsStep, through);
  sense_contacts(group, work, through);
  sense_joint_reactions(group, work, through);
  return through;
}

/// Stores the bodies before the physics step, for plugins that read them.
void CompiledScenario::remember_bodies(StateGroup& group, std::uint32_t mask) const {
  if (!needs_bodies_before_) return;
  const Block& block = layout().bodies_before;
  keep(group, mask, block.size, group.bodies(), group.writable(block, mask));
}

/// Calls the sensors that are due after this physics step, each lane by its own count. A sensor
/// that is called only when read is skipped if it is due again before the next read. It may have to
/// catch up on skipped calls, so at most SKYBODY_LONGEST_LEFT_OUT steps are skipped.
void CompiledScenario::sense(StateGroup& group, const SkybodyLanes& view,
                             std::int64_t steps_left) const {
  for (const PluginInstance& s : plugins_[SKYBODY_SENSOR]) {
    if (s.is_only_when_read && std::max(s.period, 1) <= steps_left % SKYBODY_LONGEST_LEFT_OUT)
      continue;
    SkybodyLanes v = view;
    v.active = due(s, group, view.active);
    if (v.active != 0) sense(group, v, s);
  }
}

void CompiledScenario::sense(StateGroup& group, const SkybodyLanes& view,
                             const PluginInstance& sensor) const {
  SkybodyLanes v = view;
  v.images = group.images().bytes() + sensor.images;
  v.image_stride = 8 * image_words_;
  double* const values = group.writable(layout().sensors, v.active) + sensor.output * group.lanes();
  call_plugin(
      sensor.kernels.sense, sensor, group, v,
      [&] { return CallSizes{0, sensor.channel_count(), 0, "channel", nullptr, nullptr, values}; },
      values);
}

/// Psi_i: the task's evaluation of the final state.
void CompiledScenario::evaluate(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                                bool wants_info) const {
  work.clear_outcome(wants_info);
  AlignedArray<double>& values = plan_.is_task_in_place ? work.observation : work.task_values;
  const SkybodyEvaluation out{values.data(),    work.reward.data(),
                              work.end.data(),  work.robot_reward.data(),
                              work.info.data(), wants_info ? 1u : 0u};
  call_plugin(
      task().kernels.evaluate, task(), group, view,
      [&] {
        return CallSizes{0,
                         task().channel_count(),
                         value_count(task().infos),
                         "observation",
                         values.data(),
                         wants_info ? work.info.data() : nullptr};
      },
      &out);
  if (wants_info) write_reports(group, work);
  gather_observation(group, work);
}

/// Appends to the task's infos: values that other plugins keep in their buffers, then randomizable
/// values.
void CompiledScenario::write_reports(const StateGroup& group, GroupWorkspace& work) const {
  const int lanes = group.lanes();
  double* to = work.info.data() + value_count(task().infos) * lanes;
  for (const auto& list : plugins_) {
    for (const PluginInstance& p : list) {
      for (const Report& report : p.reports) {
        const double* from = group.reals(layout().plugin_state.offset + p.buffer + report.word);
        to = std::copy_n(from, report.info.count * lanes, to);
      }
    }
  }
  for (const int param : info_params_) {
    to = std::copy_n(group.reals(layout().params.offset + param), lanes, to);
  }
}

/// Assembles the observation if the task has not written all of it in place.
void CompiledScenario::gather_observation(const StateGroup& group, GroupWorkspace& work) const {
  const int lanes = group.lanes();
  for (const ValueCopy& copy : plan_.task_copies) {
    double* const values = work.task_values.data();
    std::copy_n(values + copy.from * lanes, copy.count * lanes, values + copy.to * lanes);
  }
  for (const ObservationPart& part : plan_.parts) {
    const double* values =
        part.is_of_task ? work.task_values.data() : group.reals(layout().sensors);
    std::copy_n(values + part.from * lanes, part.count * lanes,
                work.observation.data() + part.to * lanes);
  }
}

template <class Function>
void CompiledScenario::ask_goals(StateGroup& group, GroupWorkspace& work, int lane,
                                 Function function, int size, const char* what,
                                 std::vector<double>& out) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  out.assign(task().goals.size() * static_cast<std::size_t>(size), 0.0);
  if (function == nullptr || out.empty()) return;
  const auto lanes = static_cast<std::size_t>(group.lanes());
  std::vector<double> values(out.size() * lanes);
  const SkybodyLanes v = view(group, work, 1u << lane);
  call_plugin(
      function, task(), group, v,
      [&] {
        return CallSizes{0, static_cast<int>(out.size()), 0, what, values.data()};
      },
      values.data());
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = values[k * lanes + static_cast<std::size_t>(lane)];
  }
}

void CompiledScenario::goal(StateGroup& group, GroupWorkspace& work, int lane,
                            std::vector<double>& out) const {
  ask_goals(group, work, lane, task().kernels.goal, 4, "goal", out);
}

void CompiledScenario::goal_motion(StateGroup& group, GroupWorkspace& work, int lane,
                                   std::vector<double>& out) const {
  ask_goals(group, work, lane, task().kernels.goal_motion, 6, "goal motion", out);
}

void CompiledScenario::hash(const StateGroup& group, int lane, const Rows& rows,
                            HashChain& chain) const {
  const auto lanes = static_cast<std::size_t>(group.lanes());
  const std::uint64_t* words = group.bits(0) + lane;
  const int first_observed = layout().last_observation.offset;
  for (int k = 0; k < layout().words; ++k) {
    const int word = first_observed + plan_.row.source_of(k - first_observed);
    chain.update(canonical_nan(words[static_cast<std::size_t>(word) * lanes]));
  }
  const float* row = rows.observation + static_cast<std::ptrdiff_t>(lane) * observation_size();
  for (int k = 0; k < observation_size(); ++k) chain.update(static_cast<double>(row[k]));
  const float* critic = rows.privileged + static_cast<std::ptrdiff_t>(lane) * privileged_size();
  for (int k = 0; k < privileged_size(); ++k) chain.update(static_cast<double>(critic[k]));
  for (const std::uint64_t word : group.images().of(lane)) chain.update(word);
  chain.update(static_cast<double>(rows.reward[lane]));
  chain.update(rows.status[lane]);
}

}  // namespace skybody
