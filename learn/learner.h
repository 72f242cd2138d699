// The common interface of learners.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/system/error.h"
#include "core/env/compiled_scenario.h"
#include "core/io/files/policy_file.h"
#include "learn/hyperparameters.h"

namespace skybody::learn {

/// A loss or a parameter is no longer finite. The newest checkpoint still has the state before the
/// iteration.
class Diverged : public Error {
 public:
  using Error::Error;
};

/// Result of one rollout and its update.
struct Report {
  std::int64_t steps = 0;              ///< environment steps so far, over all environments
  std::vector<float> episode_returns;  ///< of episodes that ended
  double position_error =
      std::nan("");         ///< [m], mean over the rollout; NaN: the task does not report it
  std::int64_t faults = 0;  ///< transitions that faulted
  double environment_seconds = 0.0;  ///< wall-clock time spent in environments
  double inference_seconds = 0.0;    ///< the rest of the rollout
  double update_seconds = 0.0;
  std::vector<std::pair<std::string, double>> losses;  ///< by name; one column each of progress.csv
};

/// State for a checkpoint, by name: all of a learner's state except its construction arguments.
struct LearnerState {
  std::vector<std::pair<std::string, std::vector<std::uint64_t>>> blocks;
  std::vector<std::uint64_t> environments;  ///< every word of every environment
};

/// Alternates rollouts and updates.
class Learner {
 public:
  virtual ~Learner() = default;
  /// Environment steps so far, over all environments.
  virtual std::int64_t steps() const = 0;
  /// One rollout and its update. After the first call it allocates only the report.
  /// @throws Diverged
  virtual Report iterate() = 0;
  /// The current deterministic policy; with `averaging_steps` the mean over the last updates.
  virtual PolicyFile policy() const = 0;
  /// Hash of all trained parameters, in a fixed order.
  virtual std::uint64_t parameter_hash() const = 0;
  virtual LearnerState state() const = 0;
  /// Continues from a state that state() returned.
  /// @throws Error if the state is damaged or another learner's; the learner is then unchanged
  virtual void restore(const LearnerState& state) = 0;
};

/// Arguments for the construction of a learner (make_learner.h).
struct LearnerOptions {
  std::shared_ptr<const CompiledScenario> compiled;
  Hyperparameters hyper;
  std::uint64_t seed = 0;
  std::int64_t total_steps = 0;  ///< at which schedules end
  int threads = 0;  ///< including the caller; 0: one per processor. Does not change results
};

}  // namespace skybody::learn
