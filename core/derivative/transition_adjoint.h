// Derivatives of transitions of a lane group, backwards through time: what a sum over observations,
// rewards and states of some transitions changes by with actions and states before.
//
// Forward, transitions are the engine's own, taken phase by phase, and what they go through is
// remembered. Backward, a physics step goes by its adjoint (core/physics/step/step_adjoint.h),
// plugins by their own code on dual numbers (linear_map.h). Contact is left out of derivatives: a
// step near the ground counts as one in free air.
#pragma once

#include <cstdint>
#include <vector>

#include "core/derivative/linear_map.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_work.h"
#include "core/physics/step/step_adjoint.h"

namespace skybody {

/// Goes with one group at a time: scratch of a thread, or of a slice.
class TransitionAdjoint {
 public:
  /// @param compiled  must outlive it
  /// @param steps     transitions that it remembers, at most
  /// @param with_reward  rewards have adjoints, too: they depend on much, which takes time
  /// @throws Error (naming what) if derivatives are not known: another world than StepAdjoint has,
  ///         plugins that are not smooth, sensors, effects, draws within an episode
  TransitionAdjoint(const CompiledScenario& compiled, int steps, bool with_reward);

  /// Transition `t` of the lanes in `mask`, as CompiledScenario::step, remembered.
  void step(StateGroup& group, GroupWork& work, std::uint32_t mask, const float* actions,
            int action_stride, const Rows& rows, int t);

  /// Where the task wants its first goal body now.
  /// @param out  values of all goals in lanes: position and heading of each
  void goal(StateGroup& group, GroupWork& work, std::uint32_t mask, double* out) const;

  /// Learns from the remembered transitions which values of plugins depend on which.
  void look(const StateGroup& group, std::uint32_t mask, int steps);
  /// Instead of look(): the dependences that another adjoint of the same scenario has found.
  void depend_as(const TransitionAdjoint& other);
  /// After all look(): plugins are asked as seldom as these dependences allow.
  void arrange();

  /// Makes ready to go back through the transitions of a group.
  void begin(const StateGroup& group, std::uint32_t lanes);
  /// Goes back through transition `t`.
  /// @param adjoints  row k of DualGroup at k * kGroupLanes: derivatives by values after the
  ///                  transition; overwritten by those before it
  /// @param action    action_size() rows: derivatives by the action, overwritten
  void pull_back(const StateGroup& group, int t, std::uint32_t lanes, double* adjoints,
                 double* action);

  /// Rows of `adjoints`.
  int rows() const { return dual_.rows(); }
  int observation_row() const { return dual_.observation(); }
  int reward_row() const { return dual_.reward(); }
  /// Coordinates after transition `t`, before any reset: q, then u, in lanes.
  const double* coordinates(int t) const;
  /// Evaluations on dual numbers for a transition: of the task, of the controllers.
  std::pair<int, int> evaluations() const { return {task_.set_count(), chain_.set_count()}; }

 private:
  void require_smooth() const;
  void require(const PluginInstance& plugin, bool is_there, const char* remedy) const;
  /// What of a group is remembered.
  enum class Part {
    kAll,
    kMotion,   ///< coordinates and rotors' speeds
    kCommands  ///< what controllers have just given
  };
  void remember(const StateGroup& group, double* record, Part part) const;
  void show(const double* record);
  void call_chains(std::uint32_t lanes, const double* record);
  void call_chain(const ControllerChain& chain, const SkybodyLanes& view);
  void call_task(std::uint32_t lanes, const double* record);
  void put_back(const double* record);
  SkybodyLanes view_of(std::uint32_t lanes, const double* record);
  double* record(int t, int k) {
    return records_.data() + (static_cast<std::ptrdiff_t>(t) * (repeat_ + 1) + k) * record_size_;
  }

  const CompiledScenario& compiled_;
  const Layout& layout_;
  int repeat_;      ///< physics steps of a transition
  int early_rows_;  ///< words from the header on, up to the parameters
  int late_first_;  ///< words from the action on, up to the last observation
  int late_rows_;
  std::ptrdiff_t record_size_;
  StepAdjoint step_adjoint_;
  DualGroup dual_;
  LinearMap task_, chain_;
  bool is_chain_constant_ = false;  ///< over the physics steps of an action
  AlignedArray<double> records_, derived_, signal_[2];
  AlignedArray<std::uint64_t> end_;
};

}  // namespace skybody
