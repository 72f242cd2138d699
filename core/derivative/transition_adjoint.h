// Derivatives of transitions of a lane group, backwards through time: the gradient of a sum over
// observations, rewards and states of some transitions by the actions and states before.
//
// Forward: the engine's own transitions run phase by phase, and their values are recorded
// (transition_records.h).
//
// Backward: plugins run their own code on dual numbers (dual_transition.h, sparse_jacobian.h). A
// physics step uses a closed form where one is known (core/physics/step/step_adjoint.h), else the
// engine's own step on dual numbers, one direction at a time.
//
// Limits: derivatives ignore contact. A step near the ground counts as one in free air.
#pragma once

#include <cstdint>
#include <vector>

#include "core/derivative/dual_transition.h"
#include "core/derivative/sparse_jacobian.h"
#include "core/derivative/transition_records.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"
#include "core/physics/step/step_adjoint.h"

namespace skybody {

/// For each value of a row of observations and of the privileged row: its place among the values of
/// the task, which follow TransitionAdjoint::observation_row(); -1: not of the task.
std::vector<int> task_rows(const CompiledScenario& compiled);

/// Works on one group at a time: scratch of a thread, or of a slice.
class TransitionAdjoint {
 public:
  /// @param compiled  must outlive it
  /// @param steps     greatest number of recorded transitions
  /// @param with_reward  rewards have adjoints, too: they depend on many values, which takes time
  /// @throws Error (with the cause) if derivatives are not known: integrators that choose their own
  ///   steps, Simbody's dynamics, plugins that are not smooth, sensors that are observed, draws
  ///   within an episode
  TransitionAdjoint(const CompiledScenario& compiled, int steps, bool with_reward);

  /// Transition `t` of the lanes in `mask`, as CompiledScenario::step, with a record.
  void step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, const float* actions,
            int action_stride, const Rows& rows, int t);

  /// The task's present goal for its body.
  /// @param out  7 rows in lanes: position and heading, and the goal's velocity [m/s] if the task
  ///   provides it; else the last 3 rows remain unchanged
  void goal(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, double* out);

  /// Calls look() for flights with random actions, the same in every call. Needs an FpEnvironment.
  /// @param group  any group of the scenario; its environments are overwritten
  /// @param rows   receives the outcomes of single transitions
  /// @param steps  transitions of each flight, at most as many as are recorded
  void look_at_flights(StateGroup& group, GroupWorkspace& work, const Rows& rows, int steps);
  /// Finds the dependences between values of plugins from the recorded transitions.
  void look(const StateGroup& group, std::uint32_t mask, int steps);
  /// Instead of these: copies the dependences found by another adjoint of the same scenario.
  void copy_sparsity(const TransitionAdjoint& other);
  /// Call it after all look(): reduces the evaluations of plugins to the number that these
  /// dependences require.
  void color_columns();

  /// Prepares the backward pass through the transitions of a group.
  void begin(const StateGroup& group, std::uint32_t lanes);
  /// Goes back through transition `t`.
  /// @param adjoints  row k of DualGroup at k * kGroupLanes: derivatives by values after the
  ///   transition; overwritten by those before it
  /// @param action    action_size() rows: derivatives by the action, overwritten
  void pull_back(const StateGroup& group, int t, std::uint32_t lanes, double* adjoints,
                 double* action);

  /// Rows of `adjoints`.
  int rows() const { return dual_.rows(); }
  int observation_row() const { return dual_.observation(); }
  int reward_row() const { return dual_.reward(); }
  /// The first of 13 rows: the motion of the goal's body (BodyState).
  int goal_motion_row() const { return goal_motion_; }
  /// These rows after transition `t`, before any reset.
  const double* goal_motion(int t) const { return records_.row(t, repeat_, goal_motion_); }

  /// Evaluations on dual numbers: of the task per transition, of the others per physics step.
  struct Evaluations {
    int task, controllers, effects, physics;
  };
  /// Valid after color_columns().
  Evaluations evaluations() const;

 private:
  void require_smooth() const;
  void require(const PluginInstance& plugin, bool is_there, const char* remedy) const;
  bool is_observed(const PluginInstance& sensor) const;
  bool has_periods() const;
  RecordedStep at(int t, int k, std::uint32_t lanes) const { return {records_, t, k, lanes}; }
  void look_at_step(int t, int k, std::uint32_t lanes);
  void pull_back_step(const StateGroup& group, int t, int k, std::uint32_t lanes, double* adjoints);
  void pull_back_action(double* adjoints, double* action) const;
  void pull_back_motion(const RecordedStep& step, double* adjoints);

  const CompiledScenario& compiled_;
  const StateLayout& layout_;
  StepAdjoint step_adjoint_;
  DualGroup dual_;
  TransitionRecords records_;
  DualTransition transition_;
  int repeat_;  ///< physics steps of a transition
  int goal_motion_;
  SparseJacobian task_, chain_, effects_, motion_, step_;
  bool is_chain_constant_ = false;  ///< over the physics steps of an action
  AlignedArray<double> derived_, goal_motion_values_;
};

}  // namespace skybody
