// Draws of a task at a reset, and its requirements on its robots.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>

namespace skybody::task_kit {

/// Refuses a box, given by two corners x, y, z, whose lower corner is above its upper corner.
/// @param name  of the parameters, without `_min` and `_max`
inline void require_box(const RealsParameter& low, const RealsParameter& high,
                        const std::string& name) {
  for (int k = 0; k < 3; ++k) {
    if (low.value(k) <= high.value(k)) continue;
    refuse("`", name, "_min[", k, "]` ", low.value(k), " is above `", name, "_max` ", high.value(k),
           ": swap them");
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

/// Declares that a task draws its own randomizable parameter, unless the scenario gives it.
inline void announce_drawn(const Setup& setup, const RealsParameter& parameter) {
  if (parameter.is_given()) return;
  for (int k = 0; k < parameter.count(); ++k) setup.writes(parameter.env_param() + k);
}

/// Size of the robot's action. A task that observes actions needs a controller.
inline int action_count(const RobotInfo& robot, const std::string& task) {
  if (robot.action_count > 0) return robot.action_count;
  refuse("robot `", robot.name, "` takes no action, and task `", task,
         "` observes actions: give it a controller, such as `rotor_speed`, that no team feeds");
}

/// Refuses a memory longer than an episode, whose oldest entries would never be filled.
/// @param steps  entries of the memory; @param name  of the parameter
inline void require_within_horizon(const Setup& setup, int steps, const std::string& name) {
  if (setup.horizon() == 0 || steps <= setup.horizon()) return;
  refuse("`", name, "` is ", steps, " steps, and an episode ends after ", setup.horizon(),
         ": take fewer");
}

}  // namespace skybody::task_kit
