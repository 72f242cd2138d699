// The distance from its goal that a task tells.
#pragma once

#include "core/env/compiled_scenario.h"

namespace skybody::learn {

/// Names of infos under which tasks give the distance from their goal [m], in the order of
/// preference.
inline constexpr const char* kPositionErrors[] = {"position_error", "payload_error",
                                                  "formation_error"};

/// Values of an info whose norm is that distance.
struct PositionError {
  int first = -1;  ///< value of the infos; -1: the task does not tell it
  int count = 0;

  bool is_told() const { return first >= 0; }
  /// [m]  @param info  all infos of a transition; where is_told()
  double of(const float* info) const;
};

/// The first of kPositionErrors that the scenario's task has.
PositionError find_position_error(const CompiledScenario& compiled);

}  // namespace skybody::learn
