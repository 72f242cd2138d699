// The setup of a PPO before learning: scenario, hyper-parameters and sizes derived from them.
// Identical on every machine that takes part.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/simd/isa.h"
#include "core/env/compiled_scenario.h"
#include "learn/common/seen_images.h"
#include "learn/common/slice_plan.h"
#include "learn/hyperparameters.h"
#include "learn/learner.h"
#include "learn/network/panel_matrix.h"
#include "learn/position_error.h"
#include "learn/ppo/agent_table.h"

namespace skybody::learn {

/// Layout of a row of a rollout [floats]. A row begins with the value function's inputs, which
/// begin with the policy's inputs. Rows are whole cache lines.
struct RowLayout {
  int inputs = 0, actions = 0;
  int action() const { return inputs; }
  int log_probability() const { return inputs + actions; }
  int advantage() const { return log_probability() + 1; }
  int value_target() const { return log_probability() + 2; }  ///< advantage plus value
  int stride() const { return padded(log_probability() + 3); }
};

/// Immutable.
struct PpoSetup {
  /// @throws Error as find_images(), if robots that share a policy differ in their observations or
  ///         actions, or if hyper-parameters are out of range or exclude one another
  explicit PpoSetup(const LearnerOptions& options);

  std::shared_ptr<const CompiledScenario> compiled;
  Hyperparameters hyper;
  std::uint64_t seed;
  std::int64_t total_steps;
  Isa isa;
  AgentTable agents;
  std::vector<SeenImage> images;
  SlicePlan plan;
  RowLayout row;
  PositionError error;

  /// Environment steps of a rollout.
  std::int64_t steps_per_rollout() const { return std::int64_t{hyper.envs} * hyper.rollout_steps; }
};

}  // namespace skybody::learn
