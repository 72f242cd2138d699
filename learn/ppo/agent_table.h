// Which entries of an environment's rows are seen and decided together: rows of a learner are
// environments, or the robots of a team.
#pragma once

#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody::learn {

/// For each row that an environment gives a learner, the entries of the environment's rows that
/// belong to it. All rows have the same widths.
struct AgentTable {
  std::vector<std::vector<int>> observation;  ///< what the policy sees
  std::vector<std::vector<int>> privileged;   ///< what only the value function sees, besides
  std::vector<std::vector<int>> action;       ///< what the policy decides
  bool is_shared = false;                     ///< rows are robots, with rewards of their own

  int rows() const { return static_cast<int>(observation.size()); }
  int observation_size() const { return static_cast<int>(observation[0].size()); }
  int privileged_size() const { return static_cast<int>(privileged[0].size()); }
  int action_size() const { return static_cast<int>(action[0].size()); }
};

/// One row an environment, of everything; or one row a robot that takes actions: its own columns
/// and those of nobody, and its own part of the action.
/// @throws Error if robots are to be rows and do not see or decide equally many values
AgentTable make_agent_table(const CompiledScenario& compiled, bool is_shared);

}  // namespace skybody::learn
