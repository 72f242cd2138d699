// From an action to the inputs of actuators: clip, convert to commands, run the controllers.
#pragma once

#include <cstdint>

#include "core/env/scenario_model.h"

namespace skybody {

/// Immutable; refers to the model, which must outlive it.
class ControlPhase {
 public:
  explicit ControlPhase(const ScenarioModel& model) : model_(model) {}

  /// P_i: clips the action. A row that is not finite keeps the last action and makes this
  /// transition a fault.
  /// @param actions  row of lane l at actions + l * action_stride
  void apply_action(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                    const float* actions, int action_stride) const;
  /// Converts the action to the command.
  void make_command(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view) const;
  /// Interpolates the command from the last one to the present one. The first action of an episode
  /// has no last command: its command applies at once.
  /// @param step      1..steps
  /// @param is_first  of the action
  void move_command(StateGroup& group, const GroupWorkspace& work, std::uint32_t mask, int step,
                    int steps, bool is_first) const;
  /// C_i: every chain's controllers in order, from the latest state.
  void control(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view) const;

 private:
  void control(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
               const ControllerChain& chain) const;
  void process(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view) const;
  void scale_action(const StateGroup& group, std::uint32_t mask, double* out) const;

  const ScenarioModel& model_;
};

}  // namespace skybody
