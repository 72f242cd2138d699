// Derivatives of transitions of a lane group, backwards through time: what a sum over observations,
// rewards and states of some transitions changes by with actions and states before.
//
// Forward, transitions are the engine's own, taken phase by phase, and what they go through is
// remembered (transition_records.h). Backward, plugins go by their own code on dual numbers
// (dual_transition.h, sparse_jacobian.h). A physics step goes by a closed form where one is known
// (core/physics/step/step_adjoint.h), else by the engine's own step on dual numbers, one direction
// at a time. Contact is left out of derivatives: a step near the ground counts as one in free air.
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

/// Goes with one group at a time: scratch of a thread, or of a slice.
class TransitionAdjoint {
 public:
  /// @param compiled  must outlive it
  /// @param steps     transitions that it remembers, at most
  /// @param with_reward  rewards have adjoints, too: they depend on much, which takes time
  /// @throws Error (naming what) if derivatives are not known: integrators that choose their own
  ///         steps, Simbody's dynamics, plugins that are not smooth, sensors that are observed,
  ///         draws within an episode
  TransitionAdjoint(const CompiledScenario& compiled, int steps, bool with_reward);

  /// Transition `t` of the lanes in `mask`, as CompiledScenario::step, remembered.
  void step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, const float* actions,
            int action_stride, const Rows& rows, int t);

  /// Where the task wants its goal's body now.
  /// @param out  7 rows in lanes: position and heading, and where the task says how its goal moves
  ///             the velocity [m/s]; else that stays as it is
  void goal(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, double* out);

  /// Learns from the remembered transitions which values of plugins depend on which.
  void look(const StateGroup& group, std::uint32_t mask, int steps);
  /// Instead of look(): the dependences that another adjoint of the same scenario has found.
  void copy_sparsity(const TransitionAdjoint& other);
  /// After all look(): plugins are asked as seldom as these dependences allow.
  void color_columns();

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
  /// The first of 13 rows: the motion of the goal's body (BodyState).
  int goal_motion_row() const { return goal_motion_; }
  /// These rows after transition `t`, before any reset.
  const double* goal_motion(int t) const { return records_.row(t, repeat_, goal_motion_); }

  /// Evaluations on dual numbers: for a transition of the task; for a physics step of all else.
  struct Evaluations {
    int task, controllers, effects, physics;
  };
  /// After color_columns().
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
  const Layout& layout_;
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
