// What a task draws at a reset, and what it needs of the robots that it is about.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>

namespace skybody::task_kit {

/// Refuses a box of drawn values, given by two corners of x, y, z, that is upside down.
/// @param name  of the parameters, without `_min` and `_max`
inline void require_box(const RealsParameter& low, const RealsParameter& high,
                        const std::string& name) {
  for (int k = 0; k < 3; ++k) {
    if (low.value(k) <= high.value(k)) continue;
    throw std::runtime_error("`" + name + "_min[" + std::to_string(k) + "]` " +
                             to_text(low.value(k)) + " is above `" + name + "_max` " +
                             to_text(high.value(k)) + ": swap them");
  }
}

/// A point within the box [m].
template <class Real>
SKYBODY_INLINE Vec3<Real> draw_in_box(Random<Real>& draw, const RealsParameter& low,
                                      const RealsParameter& high) {
  Real drawn[3];
  for (int k = 0; k < 3; ++k) drawn[k] = draw.uniform(Real(low.value(k)), Real(high.value(k)));
  return {drawn[0], drawn[1], drawn[2]};
}

/// Announces that a task draws a randomizable parameter of its own, unless the scenario gives it.
inline void announce_drawn(const Setup& setup, const RealsParameter& parameter) {
  if (parameter.is_given()) return;
  for (int k = 0; k < parameter.count(); ++k) setup.writes(parameter.env_param() + k);
}

/// The robot's actions; a task that observes them needs a controller.
inline int action_count(const RobotInfo& robot, const std::string& task) {
  if (robot.action_count > 0) return robot.action_count;
  throw std::runtime_error(
      "robot `" + std::string(robot.name) + "` takes no action, and task `" + task +
      "` observes actions: give it a controller, such as `rotor_speed`, that no team feeds");
}

/// Refuses a memory longer than an episode: its oldest entries would never be of it.
/// @param steps  entries of the memory; @param name  of the parameter
inline void require_within_horizon(const Setup& setup, int steps, const std::string& name) {
  if (setup.horizon() == 0 || steps <= setup.horizon()) return;
  throw std::runtime_error("`" + name + "` is " + std::to_string(steps) +
                           " steps, and an episode ends after " + std::to_string(setup.horizon()) +
                           ": take fewer");
}

}  // namespace skybody::task_kit
