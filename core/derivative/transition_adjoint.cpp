#include "core/derivative/transition_adjoint.h"

#include <algorithm>
#include <cstring>

#include "core/base/error.h"
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

void add_state(std::vector<int>& rows, const Layout& layout, const PluginInstance& p) {
  add_rows(rows, layout.plugin_state.offset + p.state, p.state_words);
  add_rows(rows, layout.plugin_state.offset + p.buffer, p.buffer_words);
}

std::vector<int> motion_rows(const Layout& l) {
  std::vector<int> rows;
  for (const Block& b : {l.q, l.u, l.rotor_speed, l.rotor_command}) add_block(rows, b);
  return rows;
}

LinearMap task_map(const CompiledScenario& c, const DualGroup& dual, bool with_reward) {
  const Layout& l = c.layout();
  std::vector<int> inputs = motion_rows(l), outputs;
  add_block(inputs, l.action);
  add_block(inputs, l.command);
  add_state(inputs, l, c.task());
  add_state(outputs, l, c.task());
  add_rows(outputs, dual.observation(), c.task().channel_count());
  if (with_reward) outputs.push_back(dual.reward());
  return {inputs, outputs};
}

LinearMap chain_map(const CompiledScenario& c) {
  const Layout& l = c.layout();
  std::vector<int> inputs = motion_rows(l), outputs;
  add_block(inputs, l.action);
  add_block(inputs, l.command);
  for (const PluginInstance& p : c.plugins(SKYBODY_CONTROLLER)) {
    for (std::vector<int>* rows : {&inputs, &outputs}) {
      add_state(*rows, l, p);
      add_block(*rows, p.last_output);
    }
  }
  add_block(outputs, l.rotor_command);
  return {inputs, outputs};
}

}  // namespace

TransitionAdjoint::TransitionAdjoint(const CompiledScenario& compiled, int steps, bool with_reward)
    : compiled_(compiled),
      layout_(compiled.layout()),
      repeat_(compiled.scenario().stepping.action_repeat),
      early_rows_(layout_.params.offset),
      late_first_(layout_.action.offset),
      late_rows_(layout_.last_observation.offset - late_first_),
      record_size_(static_cast<std::ptrdiff_t>(early_rows_ + late_rows_) * kGroupLanes),
      step_adjoint_(compiled.world()),
      dual_(compiled),
      task_(task_map(compiled, dual_, with_reward)),
      chain_(chain_map(compiled)),
      records_(static_cast<std::size_t>(record_size_) *
               static_cast<std::size_t>(steps * (repeat_ + 1))),
      derived_(step_adjoint_.make_derived()),
      end_(kGroupLanes) {
  require_smooth();
  for (auto& s : signal_) {
    s = AlignedArray<double>(static_cast<std::size_t>(2 * compiled.signal_size_ + 2) * kGroupLanes);
  }
}

void TransitionAdjoint::require(const PluginInstance& plugin, bool is_there,
                                const char* remedy) const {
  if (is_there) return;
  throw MarkedError(plugin.mark, "plugin `" + plugin.plugin + "` (" + plugin.name +
                                     ") has no derivatives that a policy can be taught by: " +
                                     remedy + ", or take --algo fast-ppo");
}

void TransitionAdjoint::require_smooth() const {
  const PluginInstance& task = compiled_.task();
  require(task, task.dual_kernels.evaluate != nullptr, "declare it smooth (docs/plugins.md)");
  require(task, task.kernels.goal != nullptr && task.goals.size() == 1, "let it have one goal");
  require(task, task.kernels.process == nullptr && !task.interpolates && task.period == 0,
          "leave the command to the controllers");
  for (const PluginInstance& c : compiled_.plugins(SKYBODY_CONTROLLER)) {
    require(c, c.dual_kernels.control != nullptr, "declare it smooth (docs/plugins.md)");
  }
  for (const PluginInstance& s : compiled_.plugins(SKYBODY_SENSOR)) {
    require(s, false, "leave the sensor out");
  }
  for (const PluginInstance& e : compiled_.plugins(SKYBODY_EFFECT)) {
    require(e, false, "leave the effect out");
  }
  for (const PluginInstance& r : compiled_.plugins(SKYBODY_RANDOMIZER)) {
    require(r, !r.draws_in_time, "draw at resets only");
  }
}

// --- forward ------------------------------------------------------------------------------------

void TransitionAdjoint::step(StateGroup& group, GroupWork& work, std::uint32_t mask,
                             const float* actions, int action_stride, const Rows& rows, int t) {
  const CompiledScenario& c = compiled_;
  work.clear_faults();
  group.refresh(mask, work.physics);
  SkybodyLanes lanes = c.view(group, work, mask);
  c.act(group, work, lanes, actions, action_stride);
  c.make_command(group, work, lanes);
  for (int k = 0; k < repeat_ && lanes.active != 0; ++k) {
    remember(group, record(t, k), k == 0 || !is_chain_constant_ ? Part::kAll : Part::kMotion);
    c.control(group, work, lanes);
    remember(group, record(t, k), Part::kCommands);
    lanes.active = c.advance(group, work, lanes.active);
  }
  count(group, kStep, mask);
  remember(group, record(t, repeat_), Part::kAll);
  c.evaluate(group, work, lanes, rows.info != nullptr);
  c.conclude(group, work, mask, false, rows);
}

void TransitionAdjoint::goal(StateGroup& group, GroupWork& work, std::uint32_t mask,
                             double* out) const {
  const PluginInstance& task = compiled_.task();
  const SkybodyLanes v = compiled_.view(group, work, mask);
  call_plugin(task.kernels.goal, task, group, v, no_sizes, out);
}

void TransitionAdjoint::remember(const StateGroup& group, double* record, Part part) const {
  const auto copy = [&](int first, int count, std::ptrdiff_t to) {
    std::memcpy(record + to * kGroupLanes, group.reals(first),
                static_cast<std::size_t>(count) * kGroupLanes * sizeof(double));
  };
  const int q = layout_.q.offset, commands = layout_.rotor_command.offset;
  switch (part) {
    case Part::kMotion:
      return copy(q, commands - q, q);
    case Part::kCommands:
      return copy(commands, layout_.rotor_command.size, commands);
    case Part::kAll:
      copy(0, early_rows_, 0);
      copy(late_first_, late_rows_, early_rows_);
  }
}

const double* TransitionAdjoint::coordinates(int t) const {
  return const_cast<TransitionAdjoint*>(this)->record(t, repeat_) +
         static_cast<std::ptrdiff_t>(layout_.q.offset) * kGroupLanes;
}

// --- dependences --------------------------------------------------------------------------------

void TransitionAdjoint::look(const StateGroup& group, std::uint32_t mask, int steps) {
  begin(group, mask);
  for (int t = 0; t < steps; ++t) {
    show(record(t, repeat_));
    task_.look(dual_, mask, [&] { call_task(mask, record(t, repeat_)); });
    show(record(t, 0));
    chain_.look(dual_, mask, [&] { call_chains(mask, record(t, 0)); });
  }
}

void TransitionAdjoint::depend_as(const TransitionAdjoint& other) {
  task_.depend_as(other.task_);
  chain_.depend_as(other.chain_);
}

void TransitionAdjoint::arrange() {
  task_.arrange();
  chain_.arrange();
  std::vector<int> changing = motion_rows(layout_);
  add_block(changing, layout_.plugin_state);
  is_chain_constant_ = !chain_.depends_on(changing);
}

// --- backward -----------------------------------------------------------------------------------

void TransitionAdjoint::begin(const StateGroup& group, std::uint32_t lanes) {
  const double* params = group.reals(layout_.params);
  dual_.set_values(layout_.params.offset, layout_.params.size, params);
  step_adjoint_.derive(params, lanes, derived_);
}

void TransitionAdjoint::pull_back(const StateGroup& group, int t, std::uint32_t lanes,
                                  double* adjoints, double* action) {
  show(record(t, repeat_));
  task_.pull_back(
      dual_, lanes, [&] { call_task(lanes, record(t, repeat_)); }, adjoints);
  const std::ptrdiff_t q = static_cast<std::ptrdiff_t>(layout_.q.offset) * kGroupLanes;
  for (int k = repeat_; k-- > 0;) {
    const double* const values = record(t, k);
    step_adjoint_.pull_back(values + q, group.reals(layout_.params), derived_, lanes, adjoints + q);
    // What depends on the command alone is the same in all steps of an action: once for their sum.
    if (is_chain_constant_ && k > 0) continue;
    show(values);
    chain_.pull_back(
        dual_, lanes, [&] { call_chains(lanes, values); }, adjoints);
  }
  double* const direct =
      adjoints + static_cast<std::ptrdiff_t>(layout_.action.offset) * kGroupLanes;
  double* const command =
      adjoints + static_cast<std::ptrdiff_t>(layout_.command.offset) * kGroupLanes;
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

void TransitionAdjoint::show(const double* record) {
  dual_.set_values(0, early_rows_, record);
  dual_.set_values(late_first_, late_rows_,
                   record + static_cast<std::ptrdiff_t>(early_rows_) * kGroupLanes);
}

SkybodyLanes TransitionAdjoint::view_of(std::uint32_t lanes, const double* record) {
  SkybodyLanes v = dual_.view();
  const auto word = [&](int k) {
    return reinterpret_cast<const std::uint64_t*>(record) +
           static_cast<std::ptrdiff_t>(k) * kGroupLanes;
  };
  v.active = lanes;
  v.key = word(kSeed);
  v.episode = word(kEpisode);
  v.step = word(kStep);
  v.physics_step = word(kPhysicsStep);
  return v;
}

void TransitionAdjoint::call_task(std::uint32_t lanes, const double* record) {
  const PluginInstance& task = compiled_.task();
  const SkybodyLanes v = view_of(lanes, record);
  const SkybodyEvaluation out{dual_.value(dual_.observation()),
                              dual_.value(dual_.reward()),
                              end_.data(),
                              nullptr,
                              nullptr,
                              0u};
  const int state = layout_.plugin_state.offset;
  task.dual_kernels.evaluate(task.self.get(), &v, dual_.words(state + task.state),
                             dual_.value(state + task.buffer), &out);
  put_back(record);
}

void TransitionAdjoint::call_chains(std::uint32_t lanes, const double* record) {
  const SkybodyLanes v = view_of(lanes, record);
  for (const ControllerChain& chain : compiled_.chains()) call_chain(chain, v);
  put_back(record);
}

void TransitionAdjoint::call_chain(const ControllerChain& chain, const SkybodyLanes& view) {
  const double* input = dual_.value(layout_.command.offset + chain.command);
  const int state = layout_.plugin_state.offset;
  const auto keep = [&](std::uint32_t lanes, const double* from, int count, double* to) {
    for (std::ptrdiff_t k = 0; k < std::ptrdiff_t{2} * count * kGroupLanes; ++k) {
      if ((lanes >> (k % kGroupLanes) & 1u) != 0) to[k] = from[k];
    }
  };
  for (int i = 0; i < chain.count; ++i) {
    const PluginInstance& c =
        compiled_.plugins(SKYBODY_CONTROLLER)[static_cast<std::size_t>(chain.first + i)];
    SkybodyLanes v = view;
    v.active = 0;
    for (int l = 0; l < kGroupLanes; ++l) {
      const std::uint64_t period = c.period > 1 ? static_cast<std::uint64_t>(c.period) : 1;
      if (view.physics_step[l] % period == 0) v.active |= view.active & (1u << l);
    }
    double* const output = signal_[i & 1].data();
    if (v.active != 0) {
      c.dual_kernels.control(c.self.get(), &v, dual_.words(state + c.state),
                             dual_.value(state + c.buffer), input, output);
    }
    input = output;
    if (c.last_output.size > 0) {
      double* const held = dual_.value(c.last_output.offset);
      keep(v.active, output, c.last_output.size, held);
      input = held;
    }
    if (i + 1 < chain.count) continue;
    const double* from = output;
    for (const ChainEnd& e : chain.ends) {
      keep(v.active, from, e.count, dual_.value((layout_.*e.block).offset + e.first));
      from += std::ptrdiff_t{2} * e.count * kGroupLanes;
    }
  }
}

/// Values, not tangents, of what plugins have changed.
void TransitionAdjoint::put_back(const double* record) {
  const Block& b = layout_.plugin_state;
  for (int k = 0; k < b.size; ++k) {
    const std::ptrdiff_t row = early_rows_ + (b.offset + k - late_first_);
    std::memcpy(dual_.value(b.offset + k), record + row * kGroupLanes,
                kGroupLanes * sizeof(double));
  }
}

}  // namespace skybody
