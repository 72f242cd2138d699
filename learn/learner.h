// The interface of learners, whichever they are, to a run.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/env/compiled_scenario.h"
#include "core/io/policy_file.h"
#include "learn/hyperparameters.h"

namespace skybody::learn {

/// A loss or a parameter is not finite any more. What was there before the iteration is still in
/// the newest checkpoint.
class Diverged : public Error {
 public:
  using Error::Error;
};

/// One rollout and its update.
struct Report {
  std::int64_t steps = 0;                ///< environment steps so far, over all environments
  std::vector<float> episode_returns;    ///< of episodes that ended
  double position_error = std::nan("");  ///< [m], mean over the rollout; NaN: the task does not say
  std::int64_t faults = 0;               ///< transitions that faulted
  double environment_seconds = 0.0;      ///< of wall-clock time, in environments
  double inference_seconds = 0.0;        ///< the rest of the rollout
  double update_seconds = 0.0;
  std::vector<std::pair<std::string, double>> losses;  ///< by name, a column each of progress.csv
};

/// Words that a checkpoint holds, by name: nothing of a learner is outside it, but what its
/// construction gives.
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
  /// One rollout and its update. After the first it allocates nothing but the report.
  /// @throws Diverged
  virtual Report iterate() = 0;
  /// The deterministic policy as of now; with `averaging_steps` the mean over the last updates.
  virtual PolicyFile policy() const = 0;
  /// Over all trained parameters, in a fixed order.
  virtual std::uint64_t parameter_hash() const = 0;
  virtual LearnerState state() const = 0;
  /// Goes on from where state() was taken.
  /// @throws Error if the state is another learner's or damaged; then nothing has changed
  virtual void restore(const LearnerState& state) = 0;
};

/// How a learner is made (make_learner.h).
struct LearnerOptions {
  std::shared_ptr<const CompiledScenario> compiled;
  Hyperparameters hyper;
  std::uint64_t seed = 0;
  std::int64_t total_steps = 0;  ///< that schedules reach their end at
  int threads = 0;               ///< the caller counted; 0: one per processor. Changes no bits
};

}  // namespace skybody::learn
