#include "learn/ppo/agent_table.h"

#include <numeric>
#include <string>

#include "core/base/system/error.h"

namespace skybody::learn {
namespace {

std::vector<int> all_entries(int count) {
  std::vector<int> entries(static_cast<std::size_t>(count));
  std::iota(entries.begin(), entries.end(), 0);
  return entries;
}

void append(std::vector<int>& entries, int first, int count) {
  for (int k = 0; k < count; ++k) entries.push_back(first + k);
}

/// The robot's own columns come first, so that all robots' columns have the same order, wherever
/// the columns without an owner are.
std::vector<int> seen_by(const CompiledScenario& compiled, int robot, bool is_privileged) {
  std::vector<int> entries;
  for (const int owner : {robot, -1}) {
    for (const ObservationColumn& c : compiled.columns()) {
      if (c.image < 0 && c.privileged == is_privileged && c.robot == owner) {
        append(entries, c.first, c.count());
      }
    }
  }
  return entries;
}

std::vector<int> decided_by(const CompiledScenario& compiled, int robot) {
  std::vector<int> entries;
  for (const ActionChannel& c : compiled.action_channels()) {
    if (c.robot == robot) append(entries, c.first, static_cast<int>(c.low.size()));
  }
  return entries;
}

void check_alike(const std::vector<std::vector<int>>& entries, const char* what,
                 const CompiledScenario& compiled) {
  for (std::size_t k = 1; k < entries.size(); ++k) {
    if (entries[k].size() == entries[0].size()) continue;
    const auto& robots = compiled.scenario().robots;
    const auto name = [&](std::size_t agent) {
      return "`" + robots[static_cast<std::size_t>(compiled.agents()[agent])].name + "`";
    };
    throw Error("`" + compiled.scenario().name + "`: " + name(0) + " has " +
                std::to_string(entries[0].size()) + " " + what + " values and " + name(k) + " " +
                std::to_string(entries[k].size()) +
                "; one policy for all robots needs equally many: set shared_policy=false");
  }
}

}  // namespace

AgentTable make_agent_table(const CompiledScenario& compiled, bool is_shared) {
  AgentTable table;
  table.is_shared = is_shared;
  if (!is_shared) {
    table.observation = {all_entries(compiled.observation_size())};
    table.privileged = {all_entries(compiled.privileged_size())};
    table.action = {all_entries(compiled.action_size())};
    return table;
  }
  if (compiled.agents().empty()) {
    throw Error("`" + compiled.scenario().name +
                "` has no robot that takes actions: set shared_policy=false");
  }
  for (const int robot : compiled.agents()) {
    table.observation.push_back(seen_by(compiled, robot, false));
    table.privileged.push_back(seen_by(compiled, robot, true));
    table.action.push_back(decided_by(compiled, robot));
  }
  check_alike(table.observation, "observed", compiled);
  check_alike(table.privileged, "privileged", compiled);
  check_alike(table.action, "action", compiled);
  return table;
}

}  // namespace skybody::learn
