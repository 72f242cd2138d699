#include "core/derivative/dual_transition.h"

#include <algorithm>

#include "core/base/simd/lane_mask.h"
#include "core/env/plugin_instance.h"
#include "core/model/combine_held_inputs.h"

namespace skybody {
namespace {

std::size_t dual_rows(std::size_t values) { return 2 * values * kGroupLanes; }

/// Copies values and tangents of `count` numbers in the given lanes.
void keep(std::uint32_t lanes, const double* from, int count, double* to) {
  for (std::ptrdiff_t k = 0; k < std::ptrdiff_t{2} * count * kGroupLanes; ++k) {
    if ((lanes >> (k % kGroupLanes) & 1u) != 0) to[k] = from[k];
  }
}

}  // namespace

DualTransition::DualTransition(const CompiledScenario& compiled, const StepPlan& plan,
                               DualGroup& dual)
    : compiled_(compiled),
      plan_(plan),
      layout_(compiled.layout()),
      dual_(dual),
      motion_(dual_motion_kernel(best_isa())),
      step_(dual_step_kernel(best_isa())),
      no_bodies_(dual_rows(13 * compiled.world().bodies.size())),
      end_(kGroupLanes),
      robot_rewards_(dual_rows(compiled.world().layout.robots.size())),
      infos_(dual_rows(static_cast<std::size_t>(value_count(compiled.task().task.infos)))),
      scratch_(dual_scratch_bytes(plan)) {
  for (auto& s : signal_) {
    s = AlignedArray<double>(dual_rows(static_cast<std::size_t>(compiled.model().signal_size + 1)));
  }
  const auto place = [&](const Block& block) { return dual.value(block.offset); };
  blocks_.lanes = kGroupLanes;
  for (const StateBlock& b : kStateBlocks) blocks_.*b.values = place(layout_.*b.place);
  for (const InputBlock& b : kInputBlocks) blocks_.*b.values = place(layout_.*b.place);
  for (std::size_t i = 0; i < layout_.held.size(); ++i) {
    if (layout_.held[i].size > 0) blocks_.held[i] = place(layout_.held[i]);
  }
}

SkybodyLanes DualTransition::view_of(const RecordedStep& step) {
  SkybodyLanes v = dual_.view();
  v.active = step.lanes;
  v.key = step.words(kSeed);
  v.episode = step.words(kEpisode);
  v.step = step.words(kStep);
  v.physics_step = step.words(kPhysicsStep);
  return v;
}

std::uint32_t DualTransition::due(const PluginInstance& plugin, const SkybodyLanes& view) const {
  if (plugin.period <= 1) return view.active;
  std::uint32_t lanes = 0;
  each_lane(view.active, [&](int l) {
    const bool is_due = view.physics_step[l] % static_cast<std::uint64_t>(plugin.period) == 0;
    lanes |= is_due ? 1u << l : 0u;
  });
  return lanes;
}

// --- plugins ------------------------------------------------------------------------------------

void DualTransition::evaluate(const RecordedStep& step) {
  const PluginInstance& task = compiled_.task();
  const SkybodyLanes v = view_of(step);
  const SkybodyEvaluation out{dual_.value(dual_.observation()),
                              dual_.value(dual_.reward()),
                              end_.data(),
                              robot_rewards_.data(),
                              infos_.data(),
                              0u};
  const int state = layout_.plugin_state.offset;
  task.dual_kernels.evaluate(task.self.get(), &v, dual_.words(state + task.memory.state),
                             dual_.value(state + task.memory.buffer), &out);
  step.records.show_plugin_state(step.t, step.k, dual_);
}

void DualTransition::control(const RecordedStep& step) {
  const SkybodyLanes v = view_of(step);
  for (const ControllerChain& chain : compiled_.chains()) control(chain, v);
  step.records.show_plugin_state(step.t, step.k, dual_);
}

void DualTransition::control(const ControllerChain& chain, const SkybodyLanes& view) {
  const double* input = dual_.value(layout_.command.offset + chain.command);
  const int state = layout_.plugin_state.offset;
  for (int i = 0; i < chain.count; ++i) {
    const PluginInstance& c =
        compiled_.plugins(SKYBODY_CONTROLLER)[static_cast<std::size_t>(chain.first + i)];
    SkybodyLanes v = view;
    v.active = due(c, view);
    double* const output = signal_[i & 1].data();
    if (v.active != 0) {
      c.dual_kernels.control(c.self.get(), &v, dual_.words(state + c.memory.state),
                             dual_.value(state + c.memory.buffer), input, output);
    }
    input = output;
    if (c.controller.last_output.size > 0) {
      double* const held = dual_.value(c.controller.last_output.offset);
      keep(v.active, output, c.controller.last_output.size, held);
      input = held;
    }
    if (i + 1 < chain.count) continue;
    const double* from = output;
    for (const ChainEnd& e : chain.ends) {
      keep(v.active, from, e.count, dual_.value((layout_.*e.block).offset + e.first));
      from += dual_rows(static_cast<std::size_t>(e.count));
    }
  }
}

void DualTransition::apply_effects(const RecordedStep& step) {
  const SkybodyLanes view = view_of(step);
  const int state = layout_.plugin_state.offset;
  std::uint32_t changed[SKYBODY_HELD_COUNT] = {};
  for (const PluginInstance& e : compiled_.plugins(SKYBODY_EFFECT)) {
    SkybodyLanes v = view;
    v.active = due(e, view);
    if (v.active == 0) continue;
    SkybodyHeld held{};
    for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
      const Block& block = e.effect.held[static_cast<std::size_t>(i)];
      if (block.size == 0) continue;
      set_neutral(i, block, v.active);
      held.input[i] = dual_.value(block.offset);
      if (block.offset != layout_.held[static_cast<std::size_t>(i)].offset) changed[i] |= v.active;
    }
    e.dual_kernels.apply(e.self.get(), &v, dual_.words(state + e.memory.state),
                         dual_.value(state + e.memory.buffer), &held);
  }
  for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
    if (changed[i] != 0) add_up_held(i, changed[i]);
  }
  step.records.show_plugin_state(step.t, step.k, dual_);
}

void DualTransition::set_neutral(int input, const Block& block, std::uint32_t lanes) {
  const int size = kHeldInputs[static_cast<std::size_t>(input)].size;
  for (int k = 0; k < block.size; ++k) {
    double* const value = dual_.value(block.offset + k);
    double* const tangent = dual_.tangent(block.offset + k);
    each_lane(lanes, [&](int l) {
      value[l] = neutral_value(input, k % size);
      tangent[l] = 0.0;
    });
  }
}

void DualTransition::add_up_held(int input, std::uint32_t lanes) {
  const auto i = static_cast<std::size_t>(input);
  const Block& block = layout_.held[i];
  const int size = kHeldInputs[i].size;
  set_neutral(input, block, lanes);
  for (const PluginInstance& e : compiled_.plugins(SKYBODY_EFFECT)) {
    if (!e.effect.holds[i]) continue;
    for (int k = 0; k < block.size; ++k) {
      double *const value = dual_.value(block.offset + k), *const tangent = value + kGroupLanes;
      const double *const own = dual_.value(e.effect.held[i].offset + k), *const turned =
                                                                              own + kGroupLanes;
      each_lane(lanes, [&](int l) {
        const Dual<double> sum = held_together(input, k % size, Dual<double>(value[l], tangent[l]),
                                               Dual<double>(own[l], turned[l]));
        value[l] = sum.value;
        tangent[l] = sum.tangent;
      });
    }
  }
}

// --- physics ------------------------------------------------------------------------------------

StepCall DualTransition::call(double* bodies) {
  blocks_.bodies = bodies;
  return {&plan_, &blocks_, nullptr, derived_, scratch_.data()};
}

void DualTransition::find_motion(const RecordedStep& step) {
  motion_(call(dual_.value(dual_.bodies())), step.lanes);
}

void DualTransition::advance(const RecordedStep& step) {
  step_(call(no_bodies_.data()), step.lanes);
  for (const StateBlock& b : kSteppedBlocks) {
    const Block& block = layout_.*b.place;
    if (block.size == 0) continue;
    dual_.set_values(block.offset, block.size, step.records.row(step.t, step.k, block.offset));
  }
}

}  // namespace skybody
