#include "app/report/episode_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace skybody {
namespace {

/// Smallest absolute difference of two angles.
double angle_between(double a, double b) {
  return std::abs(std::remainder(a - b, 2.0 * std::numbers::pi));
}

}  // namespace

void add_infos(const Simulation& simulation, std::vector<InfoRange>& ranges) {
  const std::span<const float> values = simulation.info();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ranges.resize(values.size(), {nan, nan, nan});
  std::size_t k = 0;
  for (const Channel& channel : simulation.compiled().info_channels()) {
    for (int i = 0; i < channel.count; ++i, ++k) {
      const double value = is_time_to_come(channel, values[k]) ? nan : double{values[k]};
      ranges[k] = {std::fmin(ranges[k].least, value), std::fmax(ranges[k].greatest, value), value};
    }
  }
}

bool is_time_to_come(const Channel& channel, double value) {
  return channel.unit == "s" && value < 0.0;
}

ErrorWindow::ErrorWindow(const CompiledScenario& compiled)
    : goals_(compiled.task().task.goals.size()) {
  const Stepping& stepping = compiled.scenario().stepping;
  const double steps = std::round(1.0 / (stepping.dt * stepping.action_repeat));
  length_ = static_cast<std::size_t>(std::max(1.0, steps));
  samples_.resize(goals_ * length_);
}

void ErrorWindow::add(const Simulation& simulation) {
  const std::vector<double> goals = simulation.goals();
  Sample* row = samples_.data() + (count_ % length_) * goals_;
  for (std::size_t k = 0; k < goals_; ++k) {
    const int body = simulation.compiled().task().task.goals[k].body;
    const BodyState& state = simulation.bodies()[static_cast<std::size_t>(body)];
    const double* goal = goals.data() + 4 * k;
    row[k].distance = std::hypot(state.position.x - goal[0], state.position.y - goal[1],
                                 state.position.z - goal[2]);
    row[k].yaw = angle_between(yaw_of(state.rotation), goal[3]);
  }
  ++count_;
}

std::vector<GoalError> ErrorWindow::errors() const {
  const std::size_t n = std::min(count_, length_);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (n == 0) return std::vector<GoalError>(goals_, {nan, nan, nan});
  std::vector<GoalError> errors(goals_);
  for (std::size_t i = 0; i < n * goals_; ++i) {
    GoalError& error = errors[i % goals_];
    error.mean += samples_[i].distance / static_cast<double>(n);
    error.max = std::max(error.max, samples_[i].distance);
    error.yaw += samples_[i].yaw / static_cast<double>(n);
  }
  return errors;
}

}  // namespace skybody
