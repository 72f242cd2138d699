#include "core/env/control_phase.h"

#include <algorithm>

#include "core/base/simd/lane_mask.h"
#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"
#include "core/env/row_conversion.h"

namespace skybody {

void ControlPhase::apply_action(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                                const float* actions, int action_stride) const {
  const Block& action = model_.layout().action;
  work.faults.bad_action = view.active & ~row_kernels().read_clipped_actions(
                                             view.active, group.lanes(), actions, action_stride,
                                             action.size, group.writable(action, view.active));
}

void ControlPhase::make_command(StateGroup& group, GroupWorkspace& work,
                                const SkybodyLanes& view) const {
  const StateLayout& l = model_.layout();
  const auto values = static_cast<std::size_t>(model_.commanded * group.lanes());
  if (model_.task().task.interpolates) {
    std::copy_n(group.reals(l.command), values, work.control.command_from.data());
  }
  if (model_.task().kernels.process != nullptr) {
    process(group, work, view);
  } else {
    scale_action(group, view.active, group.writable(l.command, view.active));
  }
  if (model_.task().task.interpolates) {
    std::copy_n(group.reals(l.command), values, work.control.command_to.data());
  }
}

/// Scales from [-1, 1] to the physical ranges of the action's channels.
void ControlPhase::scale_action(const StateGroup& group, std::uint32_t mask, double* out) const {
  const int lanes = group.lanes();
  const double* action = group.reals(model_.layout().action);
  for (const ActionChannel& channel : model_.action_channels) {
    row_kernels().scale(mask, lanes, action + channel.first * lanes,
                        static_cast<int>(channel.low.size()), channel.low.data(),
                        channel.high.data(), out + channel.first * lanes);
  }
}

void ControlPhase::move_command(StateGroup& group, const GroupWorkspace& work, std::uint32_t mask,
                                int step, int steps, bool is_first) const {
  const Block& block = model_.layout().command;
  const double share = static_cast<double>(step) / steps;
  const std::uint64_t* actions = group.bits(kStep);
  double* command = group.writable(block, mask);
  for (int k = 0; k < model_.commanded; ++k) {
    each_lane(mask, [&](int lane) {
      const auto at = static_cast<std::size_t>(k * group.lanes() + lane);
      const double from = work.control.command_from[at], to = work.control.command_to[at];
      const bool is_there = step == steps || (is_first && actions[lane] == 0);
      command[at] = is_there ? to : from + share * (to - from);
    });
  }
}

/// Calls the task's process(), which computes the command. A task with its own action gets its
/// physical values.
void ControlPhase::process(StateGroup& group, GroupWorkspace& work,
                           const SkybodyLanes& view) const {
  const bool has_own = !model_.task().task.actions.empty();
  if (has_own) scale_action(group, view.active, work.control.action.data());
  const double* action = has_own ? work.control.action.data() : view.action;
  call_plugin(
      model_.task().kernels.process, model_.task(), group, view,
      [&] {
        return CallSizes{model_.layout().action.size, model_.commanded, 0, "command",
                         group.writable(model_.layout().command, view.active)};
      },
      action, group.writable(model_.layout().command, view.active));
}

void ControlPhase::control(StateGroup& group, GroupWorkspace& work,
                           const SkybodyLanes& view) const {
  for (const ControllerChain& chain : model_.chains) control(group, work, view, chain);
}

void ControlPhase::control(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                           const ControllerChain& chain) const {
  const int lanes = group.lanes();
  const double* input = group.reals(model_.layout().command) + chain.command * lanes;
  for (int i = 0; i < chain.count; ++i) {
    const PluginInstance& c =
        model_.of(SKYBODY_CONTROLLER)[static_cast<std::size_t>(chain.first + i)];
    const bool is_last = i + 1 == chain.count;
    SkybodyLanes v = view;
    v.active = due(c, group, view.active);
    double* const scratch = work.control.signal[i & 1].data();
    double* const held = c.controller.last_output.size > 0
                             ? group.writable(c.controller.last_output, v.active)
                             : nullptr;
    const ChainEnd& end = chain.ends[0];
    double* const target =
        is_last ? group.writable(model_.layout().*end.block, v.active) + end.first * lanes : held;
    // If all lanes are written at once, write to the target directly; else keep the other lanes'
    // values.
    const bool is_direct = is_last && chain.ends.size() == 1 && v.active == group.occupied();
    double* const output = is_direct ? target : scratch;
    if (v.active != 0) {
      call_plugin(
          c.kernels.control, c, group, v,
          [&] {
            return CallSizes{c.controller.input_count(), c.controller.output_count(), 0, "output",
                             output};
          },
          input, output);
    }
    input = held != nullptr ? held : output;
    if (is_direct) continue;
    if (is_last) {
      const double* from = scratch;
      for (const ChainEnd& e : chain.ends) {
        keep(group, v.active, e.count, from,
             group.writable(model_.layout().*e.block, v.active) + e.first * lanes);
        from += e.count * lanes;
      }
    } else if (held != nullptr) {
      keep(group, v.active, c.controller.last_output.size, scratch, held);
    }
  }
}

}  // namespace skybody
