// The distance from the goal, as reported by tasks.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody::learn {

/// Names of infos that contain the distance from a task's goal [m], in order of preference.
inline constexpr const char* kPositionErrors[] = {"position_error", "payload_error",
                                                  "formation_error"};

/// The info values whose norm is that distance.
struct PositionError {
  int first = -1;  ///< index of the first info value; -1: the task does not report it
  int count = 0;

  bool is_told() const { return first >= 0; }
  /// [m]  @param info  all infos of a transition; requires is_told()
  double of(const float* info) const;
};

/// The first of kPositionErrors among the infos of the scenario's task.
PositionError find_position_error(const CompiledScenario& compiled);

}  // namespace skybody::learn
