// Data of one episode for the summary table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "app/report/reference_errors.h"
#include "core/simulation/simulation.h"

namespace skybody {

/// Infos by which a task reports success and reasons of failure (plugins/task_kit/verdict.h): 1 if
/// true, otherwise 0.
inline constexpr const char* kSuccessInfo = "success";
inline constexpr const char* kFailureInfoPrefix = "failed.";

/// Distance between a goal and its body in the last second of an episode.
struct GoalError {
  double mean = 0.0;  ///< distance of the body's origin [m]
  double max = 0.0;
  double yaw = 0.0;  ///< mean absolute error [rad]
};

/// Values of an info over an episode's steps. NaN for a time that has not come.
struct InfoRange {
  double least = 0.0;
  double greatest = 0.0;
  double last = 0.0;
};

struct EpisodeSummary {
  std::uint64_t steps = 0;
  double time = 0.0;  ///< [s]
  double total_reward = 0.0;
  std::string end;               ///< terminated, truncated, fault, stopped or interrupted
  std::vector<GoalError> goals;  ///< as the task declares them
  std::vector<ReferenceError> references;
  std::vector<std::vector<double>> params;  ///< drawn values: at the reset, then after each change
  std::vector<InfoRange> infos;             ///< in the order of the info row; empty: no step
  std::uint64_t redraws = 0;                ///< number of times that the start was redrawn
  std::uint64_t clipped = 0;                ///< action values that the policy clipped to [-1, 1]
};

/// Plugins report a time below 0 for an event that does not happen in the episode, such as a
/// rotor's failure.
bool is_time_to_come(const Channel& channel, double value);

/// Adds the infos after a step.
void add_infos(const Simulation& simulation, std::vector<InfoRange>& ranges);

/// Keeps the goal errors of the last second of simulated time.
class ErrorWindow {
 public:
  explicit ErrorWindow(const CompiledScenario& compiled);

  /// Adds the state after a step.
  void add(const Simulation& simulation);
  /// Errors over the last second, or over all added steps if fewer; NaN if there are none.
  std::vector<GoalError> errors() const;

 private:
  struct Sample {
    double distance;
    double yaw;
  };

  std::size_t goals_;
  std::size_t length_;           ///< steps
  std::size_t count_ = 0;        ///< steps added
  std::vector<Sample> samples_;  ///< ring: step-major
};

}  // namespace skybody
