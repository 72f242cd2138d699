// The end of a transition: the task's evaluation, horizon and faults, and the rows for the learner.
//
// Every lane is first finished as if it had no fault. Faults are rare; they are corrected
// afterwards, lane by lane.
#pragma once

#include <cstdint>

#include "core/env/fault_reasons.h"
#include "core/env/scenario_model.h"

namespace skybody {

/// Output rows of a transition. The row of lane l begins at l times the row's width.
struct Rows {
  float* observation = nullptr;           ///< width observation_size()
  float* reward = nullptr;                ///< width 1
  std::uint64_t* status = nullptr;        ///< EpisodeStatus bits, width 1
  float* agent_reward = nullptr;          ///< width agents().size(); optional
  float* info = nullptr;                  ///< width info_size(); optional
  float* privileged = nullptr;            ///< width privileged_size(); optional
  std::uint8_t* const* images = nullptr;  ///< one buffer per image, in bytes; optional
};

/// Immutable; refers to its arguments, which must outlive it.
class OutcomePhase {
 public:
  OutcomePhase(const ScenarioModel& model, const FaultReasons& faults)
      : model_(model), plan_(model.observation), faults_(faults) {}

  /// Psi_i: the task's evaluation of the final state, into the workspace.
  void evaluate(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                bool wants_info) const;
  /// Horizon and faults, then the rows. A fault gives the last finite observation and reward 0.
  void finish(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, bool is_reset,
              const Rows& rows) const;

 private:
  void write_reports(const StateGroup& group, GroupWorkspace& work) const;
  void gather_observation(const StateGroup& group, GroupWorkspace& work) const;
  void keep_observation(StateGroup& group, const GroupWorkspace& work, std::uint32_t mask) const;
  std::uint32_t write_row(std::uint32_t mask, int lanes, const double* values, float* rows) const;
  std::uint32_t write_observation(GroupWorkspace& work, std::uint32_t mask, const Rows& rows) const;
  void write_images(const StateGroup& group, std::uint32_t mask, const Rows& rows) const;
  void write_last_observation(const StateGroup& group, std::uint32_t mask, const Rows& rows) const;
  std::uint32_t finite_robot_rewards(const GroupWorkspace& work, std::uint32_t mask) const;
  void finish_faults(StateGroup& group, GroupWorkspace& work, std::uint32_t faults,
                     std::uint32_t finite, const Rows& rows) const;
  void write_agent_rewards(GroupWorkspace& work, std::uint32_t mask, const Rows& rows) const;

  const ScenarioModel& model_;
  const ObservationPlan& plan_;
  const FaultReasons& faults_;
};

}  // namespace skybody
