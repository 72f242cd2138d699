#include "core/derivative/transition_adjoint.h"

#include <algorithm>
#include <numeric>

#include "core/base/system/error.h"
#include "core/env/group_lanes.h"
#include "core/env/plugin_call.h"

namespace skybody {
namespace {

void add_rows(std::vector<int>& rows, int first, int count) {
  for (int k = 0; k < count; ++k) rows.push_back(first + k);
}

void add_block(std::vector<int>& rows, const Block& block) {
  add_rows(rows, block.offset, block.size);
}

void add_state(std::vector<int>& rows, const StateLayout& layout, const PluginInstance& p) {
  add_rows(rows, layout.plugin_state.offset + p.memory.state, p.memory.state_words);
  add_rows(rows, layout.plugin_state.offset + p.memory.buffer, p.memory.buffer_words);
}

/// The outputs of controllers.
constexpr Block StateLayout::*kCommandBlocks[] = {&StateLayout::rotor_command, &StateLayout::wrench,
                                                  &StateLayout::drive, &StateLayout::joint_command};

/// The rows of the world's motion that plugins read.
std::vector<int> motion_rows(const StateLayout& l, const DualGroup& dual) {
  std::vector<int> rows;
  for (const Block& b : {l.q, l.u, l.rotor_speed, l.rotor_command}) add_block(rows, b);
  add_rows(rows, dual.bodies(), dual.body_rows());
  return rows;
}

SparseJacobian task_map(const CompiledScenario& c, const DualGroup& dual, bool with_reward) {
  const StateLayout& l = c.layout();
  std::vector<int> inputs = motion_rows(l, dual), outputs;
  add_block(inputs, l.action);
  add_block(inputs, l.command);
  add_state(inputs, l, c.task());
  add_state(outputs, l, c.task());
  add_rows(outputs, dual.observation(), c.task().channel_count());
  if (with_reward) outputs.push_back(dual.reward());
  return {inputs, outputs};
}

SparseJacobian chain_map(const CompiledScenario& c, const DualGroup& dual) {
  const StateLayout& l = c.layout();
  std::vector<int> inputs = motion_rows(l, dual), outputs;
  add_block(inputs, l.action);
  add_block(inputs, l.command);
  for (const PluginInstance& p : c.plugins(SKYBODY_CONTROLLER)) {
    for (std::vector<int>* rows : {&inputs, &outputs}) {
      add_state(*rows, l, p);
      add_block(*rows, p.controller.last_output);
    }
  }
  for (const auto block : kCommandBlocks) {
    add_block(outputs, l.*block);
    // A controller that is not due leaves its block unchanged; `rotor_command` is part of the
    // motion.
    if (block != &StateLayout::rotor_command) add_block(inputs, l.*block);
  }
  return {inputs, outputs};
}

SparseJacobian effects_map(const CompiledScenario& c, const DualGroup& dual) {
  const StateLayout& l = c.layout();
  std::vector<int> inputs = motion_rows(l, dual), outputs;
  for (std::vector<int>* rows : {&inputs, &outputs}) {
    for (const Block& held : l.held) add_block(*rows, held);
    for (const PluginInstance& e : c.plugins(SKYBODY_EFFECT)) {
      add_state(*rows, l, e);
      for (std::size_t i = 0; i < e.effect.held.size(); ++i) {
        if (e.effect.held[i].offset != l.held[i].offset) add_block(*rows, e.effect.held[i]);
      }
    }
  }
  return {inputs, outputs};
}

SparseJacobian motion_map(const StateLayout& l, const DualGroup& dual) {
  std::vector<int> inputs, outputs;
  add_block(inputs, l.q);
  add_block(inputs, l.u);
  add_rows(outputs, dual.bodies(), dual.body_rows());
  return {inputs, outputs};
}

/// The physics step as a map. It includes only held inputs that depend on the motion.
SparseJacobian step_map(const StateLayout& l, const SparseJacobian& effects) {
  std::vector<int> inputs, outputs;
  for (std::vector<int>* rows : {&inputs, &outputs}) {
    for (const Block& b : {l.q, l.u, l.rotor_speed, l.joint_state}) add_block(*rows, b);
  }
  for (const auto block : kCommandBlocks) add_block(inputs, l.*block);
  for (const Block& held : l.held) {
    for (int k = 0; k < held.size; ++k) {
      if (effects.changes(held.offset + k)) inputs.push_back(held.offset + k);
    }
  }
  return {inputs, outputs};
}

}  // namespace

std::vector<int> task_rows(const CompiledScenario& compiled) {
  const ObservationPlan& plan = compiled.model().observation;
  std::vector<int> rows(static_cast<std::size_t>(plan.size()), -1);
  if (plan.is_task_in_place) {
    std::iota(rows.begin(), rows.begin() + compiled.task().channel_count(), 0);
  }
  for (const ObservationPart& part : plan.parts) {
    if (part.is_of_task) {
      std::iota(rows.begin() + part.to, rows.begin() + part.to + part.count, part.from);
    }
  }
  return rows;
}

TransitionAdjoint::TransitionAdjoint(const CompiledScenario& compiled, int steps, bool with_reward)
    : compiled_(compiled),
      layout_(compiled.layout()),
      step_adjoint_(compiled.world()),
      dual_(compiled),
      records_(compiled, dual_, steps),
      transition_(compiled, step_adjoint_.plan(), dual_),
      repeat_(records_.repeat()),
      goal_motion_(dual_.bodies()),
      task_(task_map(compiled, dual_, with_reward)),
      chain_(chain_map(compiled, dual_)),
      effects_(effects_map(compiled, dual_)),
      motion_(motion_map(layout_, dual_)),
      step_({}, {}),
      derived_(step_adjoint_.make_derived()),
      goal_motion_values_(6 * kGroupLanes) {
  require_smooth();
  goal_motion_ += 13 * compiled.task().task.goals[0].body;
}

void TransitionAdjoint::require(const PluginInstance& plugin, bool is_there,
                                const char* remedy) const {
  if (is_there) return;
  throw LocatedError(plugin.mark, "plugin `" + plugin.plugin + "` (" + plugin.name +
                                      ") has no derivatives that a policy can be taught by: " +
                                      remedy + ", or train with fast-ppo, which takes none");
}

void TransitionAdjoint::require_smooth() const {
  const PluginInstance& task = compiled_.task();
  require(task, task.dual_kernels.evaluate != nullptr, "declare it smooth (docs/plugins.md)");
  require(task, task.kernels.goal != nullptr && task.task.goals.size() == 1,
          "let it have one goal");
  require(task, task.kernels.process == nullptr && !task.task.interpolates && task.period == 0,
          "leave the command to the controllers");
  for (const PluginInstance& c : compiled_.plugins(SKYBODY_CONTROLLER)) {
    require(c, c.dual_kernels.control != nullptr, "declare it smooth (docs/plugins.md)");
  }
  for (const PluginInstance& e : compiled_.plugins(SKYBODY_EFFECT)) {
    require(e, e.dual_kernels.apply != nullptr, "declare it smooth (docs/plugins.md)");
  }
  for (const PluginInstance& s : compiled_.plugins(SKYBODY_SENSOR)) {
    require(s, !is_observed(s), "observe the task's own values");
  }
  for (const SkybodyKind kind : {SKYBODY_TASK, SKYBODY_CONTROLLER, SKYBODY_EFFECT}) {
    for (const PluginInstance& p : compiled_.plugins(kind)) {
      require(p, p.reads.empty(), "let it do without sensors");
      require(p, !p.needs_bodies_before, "let it do without where bodies were before");
    }
  }
  for (const PluginInstance& r : compiled_.plugins(SKYBODY_RANDOMIZER)) {
    require(r, !r.randomizer.draws_in_time, "draw at resets only");
  }
}

/// Whether any of a sensor's values are in a row of observations. Images and privileged values are
/// not: they count as given.
bool TransitionAdjoint::is_observed(const PluginInstance& sensor) const {
  const ObservationPlan& plan = compiled_.model().observation;
  return std::any_of(plan.parts.begin(), plan.parts.end(), [&](const ObservationPart& part) {
    return !part.is_of_task && part.to < plan.observation_size &&
           part.from < sensor.sensor.output + sensor.channel_count() &&
           sensor.sensor.output < part.from + part.count;
  });
}

// --- forward ------------------------------------------------------------------------------------

void TransitionAdjoint::step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                             const float* actions, int action_stride, const Rows& rows, int t) {
  const TransitionPhases& phases = compiled_.phases();
  // Without effects, and with controllers that read the command only, the motion is a full record.
  const bool is_short = is_chain_constant_ && compiled_.plugins(SKYBODY_EFFECT).empty();
  work.faults.clear();
  group.refresh(mask, work.physics);
  SkybodyLanes lanes = compiled_.model().view(group, work, mask);
  phases.control.apply_action(group, work, lanes, actions, action_stride);
  phases.control.make_command(group, work, lanes);
  for (int k = 0; k < repeat_ && lanes.active != 0; ++k) {
    records_.remember(group, t, k, k == 0 || !is_short ? RecordPart::kAll : RecordPart::kMotion);
    phases.control.control(group, work, lanes);
    phases.effects.apply(group, lanes);
    records_.remember(group, t, k, RecordPart::kCommands);
    const int steps_left = repeat_ - 1 - k;
    lanes.active = phases.physics.advance(group, work, lanes.active, steps_left);
    phases.sensing.sense_due(group, lanes, steps_left);
  }
  count(group, kStep, mask);
  records_.remember(group, t, repeat_, RecordPart::kAll);
  phases.outcome.evaluate(group, work, lanes, rows.info != nullptr);
  phases.outcome.finish(group, work, mask, false, rows);
}

void TransitionAdjoint::goal(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                             double* out) {
  const PluginInstance& task = compiled_.task();
  const SkybodyLanes v = compiled_.model().view(group, work, mask);
  call_plugin(task.kernels.goal, task, group, v, no_sizes, out);
  if (task.kernels.goal_motion == nullptr) return;  // at rest: the caller's zeros
  double* const motion = goal_motion_values_.data();
  call_plugin(task.kernels.goal_motion, task, group, v, no_sizes, motion);
  std::copy_n(motion, 3 * kGroupLanes, out + 4 * kGroupLanes);
}

// --- dependences --------------------------------------------------------------------------------

void TransitionAdjoint::look_at_flights(StateGroup& group, GroupWorkspace& work, const Rows& rows,
                                        int steps) {
  constexpr std::uint32_t kAllLanes = ~0u;
  constexpr std::uint64_t kKey = 0x67726164;  // arbitrary
  for (int l = 0; l < kGroupLanes; ++l) {
    compiled_.initialize(group, l, kKey, static_cast<std::uint64_t>(l));
  }
  const int width = compiled_.action_size();
  std::vector<float> actions(static_cast<std::size_t>(kGroupLanes * width));
  for (int round = 0; round < 2; ++round) {
    compiled_.reset(group, work, kAllLanes, rows);
    for (int t = 0; t < steps; ++t) {
      for (std::size_t k = 0; k < actions.size(); ++k) {
        const std::uint64_t mixed =
            (k + 1) * 0x9e3779b97f4a7c15ull * static_cast<std::uint64_t>(t + 1 + 100 * round);
        actions[k] = static_cast<float>(mixed >> 40) * 0x1p-23f - 1.0f;
      }
      step(group, work, kAllLanes, actions.data(), width, rows, t);
    }
    look(group, kAllLanes, std::min(steps, 8));
  }
}

void TransitionAdjoint::look(const StateGroup& group, std::uint32_t mask, int steps) {
  begin(group, mask);
  for (int t = 0; t < steps; ++t) {
    const RecordedStep end = at(t, repeat_, mask);
    records_.show(t, repeat_, dual_);
    task_.look(dual_, mask, [&] { transition_.evaluate(end); });
    if (dual_.body_rows() > 0) {
      motion_.look(dual_, mask, [&] { transition_.find_motion(end); });
    }
    look_at_step(t, 0, mask);
    // If plugins have periods, outputs kept by a plugin that is not due are visible in other steps.
    if (has_periods() && repeat_ > 1) look_at_step(t, 1, mask);
  }
}

void TransitionAdjoint::look_at_step(int t, int k, std::uint32_t lanes) {
  const RecordedStep step = at(t, k, lanes);
  records_.show(t, k, dual_);
  chain_.look(dual_, lanes, [&] { transition_.control(step); });
  effects_.look(dual_, lanes, [&] { transition_.apply_effects(step); });
}

bool TransitionAdjoint::has_periods() const {
  for (const SkybodyKind kind : {SKYBODY_CONTROLLER, SKYBODY_EFFECT}) {
    for (const PluginInstance& p : compiled_.plugins(kind)) {
      if (p.period > 1) return true;
    }
  }
  return false;
}

void TransitionAdjoint::copy_sparsity(const TransitionAdjoint& other) {
  task_.copy_sparsity(other.task_);
  chain_.copy_sparsity(other.chain_);
  effects_.copy_sparsity(other.effects_);
  motion_.copy_sparsity(other.motion_);
}

void TransitionAdjoint::color_columns() {
  for (SparseJacobian* map : {&task_, &chain_, &effects_, &motion_}) map->color_columns();
  std::vector<int> changing = motion_rows(layout_, dual_);
  add_block(changing, layout_.plugin_state);
  is_chain_constant_ = !chain_.depends_on(changing);
  if (step_adjoint_.has_closed_form()) return;
  // Assume a full dependence of the step: some dependences do not occur in a few trajectories, such
  // as that on a rope that becomes taut later.
  step_ = step_map(layout_, effects_);
  step_.take_all();
  step_.color_columns();
}

TransitionAdjoint::Evaluations TransitionAdjoint::evaluations() const {
  return {task_.set_count(), chain_.set_count(), effects_.set_count(), step_.set_count()};
}

// --- backward -----------------------------------------------------------------------------------

void TransitionAdjoint::begin(const StateGroup& group, std::uint32_t lanes) {
  const double* params = group.reals(layout_.params);
  dual_.set_values(layout_.params.offset, layout_.params.size, params);
  step_adjoint_.derive(params, lanes, derived_);
  transition_.set_parameters(params, derived_.data());
}

void TransitionAdjoint::pull_back(const StateGroup& group, int t, std::uint32_t lanes,
                                  double* adjoints, double* action) {
  const RecordedStep end = at(t, repeat_, lanes);
  records_.show(t, repeat_, dual_);
  task_.pull_back(
      dual_, lanes, [&] { transition_.evaluate(end); }, adjoints);
  pull_back_motion(end, adjoints);
  for (int k = repeat_; k-- > 0;) pull_back_step(group, t, k, lanes, adjoints);
  pull_back_action(adjoints, action);
}

void TransitionAdjoint::pull_back_step(const StateGroup& group, int t, int k, std::uint32_t lanes,
                                       double* adjoints) {
  const RecordedStep step = at(t, k, lanes);
  const bool is_quick = step_adjoint_.has_closed_form();
  // Dependences on the command alone are the same in all steps of an action: evaluate them once,
  // for the sum.
  const bool has_chain = k == 0 || !is_chain_constant_;
  if (!is_quick || has_chain || effects_.set_count() > 0) records_.show(t, k, dual_);
  if (is_quick) {
    const int q = layout_.q.offset;
    step_adjoint_.pull_back(records_.row(t, k, q), group.reals(layout_.params), derived_, lanes,
                            adjoints + static_cast<std::ptrdiff_t>(q) * kGroupLanes);
  } else {
    step_.pull_back(
        dual_, lanes, [&] { transition_.advance(step); }, adjoints);
  }
  effects_.pull_back(
      dual_, lanes, [&] { transition_.apply_effects(step); }, adjoints);
  if (has_chain)
    chain_.pull_back(
        dual_, lanes, [&] { transition_.control(step); }, adjoints);
  if (has_chain || effects_.set_count() > 0) pull_back_motion(step, adjoints);
}

void TransitionAdjoint::pull_back_motion(const RecordedStep& step, double* adjoints) {
  if (dual_.body_rows() == 0) return;
  motion_.pull_back(
      dual_, step.lanes, [&] { transition_.find_motion(step); }, adjoints);
}

void TransitionAdjoint::pull_back_action(double* adjoints, double* action) const {
  const auto rows = [&](const Block& block) {
    return adjoints + static_cast<std::ptrdiff_t>(block.offset) * kGroupLanes;
  };
  double *const direct = rows(layout_.action), *const command = rows(layout_.command);
  for (const ActionChannel& channel : compiled_.action_channels()) {
    for (std::size_t k = 0; k < channel.low.size(); ++k) {
      const double scale = 0.5 * (channel.high[k] - channel.low[k]);
      const std::size_t first = (static_cast<std::size_t>(channel.first) + k) * kGroupLanes;
      for (std::size_t l = first; l < first + kGroupLanes; ++l) {
        action[l] = direct[l] + scale * command[l];
        direct[l] = command[l] = 0.0;
      }
    }
  }
}

}  // namespace skybody
