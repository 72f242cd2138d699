#include "core/env/effects_phase.h"

#include "core/base/simd/lane_mask.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"
#include "core/env/row_conversion.h"
#include "core/model/combine_held_inputs.h"

namespace skybody {
namespace {

void fill_neutral(StateGroup& group, std::uint32_t mask, int input, Block block) {
  const HeldInputRow& row = kHeldInputs[static_cast<std::size_t>(input)];
  double neutral[kMostHeldValues];
  for (int k = 0; k < row.size; ++k) neutral[k] = neutral_value(input, k);
  row_kernels().fill(mask, group.lanes(), neutral, row.size, block.size,
                     group.writable(block, mask));
}

/// Checked mode: an effect may hold NaN only where the neutral value is NaN.
void check_held(const StateGroup& group, const PluginInstance& effect) {
  for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
    const Block& block = effect.effect.held[static_cast<std::size_t>(i)];
    for (int k = 0; k < block.size; ++k) {
      const double value = group.reals(block)[k];
      const double neutral = neutral_value(i, k % kHeldInputs[static_cast<std::size_t>(i)].size);
      if (value == value || neutral != neutral) continue;
      throw_plugin_error(effect, "gives NaN as value " + std::to_string(k) + " of " +
                                     std::to_string(block.size) + " of the held input `" +
                                     kHeldInputs[static_cast<std::size_t>(i)].name + "`");
    }
  }
}

}  // namespace

void EffectsPhase::apply(StateGroup& group, const SkybodyLanes& view) const {
  std::uint32_t changed[SKYBODY_HELD_COUNT] = {};
  for (const PluginInstance& e : model_.of(SKYBODY_EFFECT)) {
    SkybodyLanes v = view;
    v.active = e.effect.is_steady ? view.active & ~group.settled() : due(e, group, view.active);
    if (v.active == 0) continue;
    SkybodyHeld held{};
    for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
      const Block& block = e.effect.held[static_cast<std::size_t>(i)];
      if (block.size == 0) continue;
      fill_neutral(group, v.active, i, block);
      held.input[i] = group.writable(block, v.active);
      if (block.offset != model_.layout().held[static_cast<std::size_t>(i)].offset)
        changed[i] |= v.active;
    }
    const SkybodyHeld* const inputs = &held;
    call_plugin(e.kernels.apply, e, group, v, no_sizes, inputs);
    if (view.checks != nullptr) check_held(group, e);
  }
  group.settle(view.active);
  for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
    if (changed[i] != 0) add_up(group, changed[i], i);
  }
}

/// Combines the contributions of several effects to one input.
void EffectsPhase::add_up(StateGroup& group, std::uint32_t mask, int input) const {
  const auto i = static_cast<std::size_t>(input);
  const Block& block = model_.layout().held[i];
  const int lanes = group.lanes(), size = kHeldInputs[i].size;
  double* sum = group.writable(block, mask);
  fill_neutral(group, mask, input, block);
  for (const PluginInstance& e : model_.of(SKYBODY_EFFECT)) {
    if (!e.effect.holds[i]) continue;
    const double* own = group.reals(e.effect.held[i]);
    for (int k = 0; k < block.size; ++k) {
      each_lane(mask, [&](int lane) {
        double& value = sum[k * lanes + lane];
        value = held_together(input, k % size, value, own[k * lanes + lane]);
      });
    }
  }
}

void EffectsPhase::clear(StateGroup& group, std::uint32_t mask) const {
  group.unsettle(mask);
  for (int i = 0; i < SKYBODY_HELD_COUNT; ++i) {
    const Block& block = model_.layout().held[static_cast<std::size_t>(i)];
    if (block.size > 0) fill_neutral(group, mask, i, block);
    for (const PluginInstance& e : model_.of(SKYBODY_EFFECT)) {
      const Block& own = e.effect.held[static_cast<std::size_t>(i)];
      if (own.size > 0) fill_neutral(group, mask, i, own);
    }
  }
}

}  // namespace skybody
