// Rows of a learner: each is an environment, or one robot of a team. A row has its own part of the
// environment's observation and action.
#pragma once

#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody::learn {

/// For each of an environment's rows, the entries of the environment's values that belong to it.
/// All rows have the same widths.
struct AgentTable {
  std::vector<std::vector<int>> observation;  ///< observed by the policy
  std::vector<std::vector<int>> privileged;   ///< observed by the value function only
  std::vector<std::vector<int>> action;       ///< chosen by the policy
  bool is_shared = false;                     ///< rows are robots, each with its own reward

  int rows() const { return static_cast<int>(observation.size()); }
  int observation_size() const { return static_cast<int>(observation[0].size()); }
  int privileged_size() const { return static_cast<int>(privileged[0].size()); }
  int action_size() const { return static_cast<int>(action[0].size()); }
};

/// One row per environment with all values; or one row per robot with actions: its own columns, the
/// columns that belong to no robot, and its own part of the action.
/// @throws Error if rows are to be robots and their observations or actions differ in size
AgentTable make_agent_table(const CompiledScenario& compiled, bool is_shared);

}  // namespace skybody::learn
