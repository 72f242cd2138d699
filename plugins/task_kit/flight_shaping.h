// What a task's own reward lacks for a learner: slopes far from the goal and close to it, a price
// on tilting and on failing. A member of a task, among its parameters.
#pragma once

#include <skybody/plugin.h>

#include "plugins/task_kit/shaping.h"

namespace skybody::task_kit {

/// The terms and their weights, all zero unless the scenario asks for them.
class FlightShaping {
 public:
  explicit FlightShaping(Plugin* owner) : owner_(owner) {}

  /// Whether the scenario asks for any term. From configure() on.
  bool is_used() const {
    return approach_reward_.value() != 0.0 || precision_reward_.value() != 0.0 ||
           heading_reward_.value() != 0.0 || tilt_cost_.value() != 0.0 ||
           failure_reward_.value() != 0.0;
  }

  /// A robot's reward with the terms.
  /// @param reward     the task's own
  /// @param distance   from where the robot belongs [m]
  /// @param yaw_error  of the heading it should have [rad]
  /// @param rotation   W from B
  /// @param failed     whether the episode ends by a failure of this robot
  template <class Real>
  SKYBODY_INLINE Real added_to(const Real& reward, const Real& distance, const Real& yaw_error,
                               const Quat<Real>& rotation, const MaskOf<Real>& failed) const {
    const Real slopes = approach_reward_.value() * approach(distance, kApproachRange) +
                        precision_reward_.value() * closeness(distance, kPrecisionWeight) +
                        heading_reward_.value() * closeness(yaw_error * yaw_error, kHeadingWeight);
    return reward + slopes - tilt_cost_.value() * tilt_wall(rotation, kLeastCosine) +
           select(failed, Real(failure_reward_.value()), Real(0.0));
  }

 private:
  static constexpr double kApproachRange = 10.0;   // [m], about the largest distance at a start
  static constexpr double kPrecisionWeight = 5.0;  // 1 / 0.2 m
  static constexpr double kHeadingWeight = 4.0;    // (1 / 0.5 rad)^2
  static constexpr double kLeastCosine = 0.1;      // where the wall of the tilt ends, at 84 degrees

  Plugin* owner_;
  RealParameter approach_reward_{
      owner_,
      {.name = "approach_reward",
       .value = 0.0,
       .min = 0.0,
       .doc = "weight of max(0, 1 - |e| / 10 m) in the reward: a slope far from the target"}};
  RealParameter precision_reward_{
      owner_,
      {.name = "precision_reward",
       .value = 0.0,
       .min = 0.0,
       .doc = "weight of 1 / (1 + |e| / 0.2 m) in the reward: a slope up to the target"}};
  RealParameter heading_reward_{owner_,
                                {.name = "heading_reward",
                                 .value = 0.0,
                                 .min = 0.0,
                                 .doc = "weight of 1 / (1 + (e_psi / 0.5 rad)^2) in the reward: a "
                                        "slope far from the heading, too"}};
  RealParameter tilt_cost_{
      owner_,
      {.name = "tilt_cost",
       .value = 0.0,
       .min = 0.0,
       .doc =
           "weight of 1 / max(cos tilt, 0.1) - 1, taken off the reward: what dashing off costs"}};
  RealParameter failure_reward_{owner_,
                                {.name = "failure_reward",
                                 .value = 0.0,
                                 .max = 0.0,
                                 .doc = "added where an episode terminates"}};
};

}  // namespace skybody::task_kit
