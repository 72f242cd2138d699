// Reward terms that the paper's rewards lack and a learner needs: slopes far from the goal and up
// to it, and a cost of tilting. The weights are parameters of the task, 0 by default.
#pragma once

#include <skybody/plugin.h>

#include "plugins/task_kit/shaping.h"

namespace skybody::task_kit {

/// The weights and their terms. Make it a member of a task, among its parameters.
class GoalShaping {
 public:
  explicit GoalShaping(Plugin* owner) : owner_(owner) {}

  /// Whether any weight is not 0.
  bool is_asked_for() const {
    return approach_reward_.value() != 0.0 || precision_reward_.value() != 0.0 ||
           heading_reward_.value() != 0.0 || tilt_cost_.value() != 0.0;
  }

  /// @param distance   from the goal [m]; @param yaw_error  wrapped [rad]
  template <class Real>
  SKYBODY_INLINE Real reward(const Real& distance, const Real& yaw_error) const {
    return approach_reward_.value() * approach(distance, kApproachRange) +
           precision_reward_.value() * closeness(distance, kPrecisionWeight) +
           heading_reward_.value() * closeness(yaw_error * yaw_error, kHeadingWeight);
  }
  /// Cost of a robot's tilt, to be subtracted from the reward.
  template <class Real>
  SKYBODY_INLINE Real cost(const Quat<Real>& rotation) const {
    return tilt_cost_.value() * tilt_wall(rotation, kLeastCosine);
  }

 private:
  static constexpr double kApproachRange = 10.0;   // [m], about the largest distance at a start
  static constexpr double kPrecisionWeight = 5.0;  // 1 / 0.2 m
  static constexpr double kHeadingWeight = 4.0;    // (1 / 0.5 rad)^2
  static constexpr double kLeastCosine = 0.1;      // end of the tilt wall, at 84 degrees

  Plugin* owner_;
  RealParameter approach_reward_{
      owner_,
      real("approach_reward", "", 0.0, at_least(0.0),
           "weight of max(0, 1 - |e| / 10 m) in the reward: a gradient far from the target")};
  RealParameter precision_reward_{
      owner_,
      real("precision_reward", "", 0.0, at_least(0.0),
           "weight of 1 / (1 + |e| / 0.2 m) in the reward: a gradient close to the target")};
  RealParameter heading_reward_{owner_, real("heading_reward", "", 0.0, at_least(0.0),
                                             "weight of 1 / (1 + (e_psi / 0.5 rad)^2) in the "
                                             "reward: a gradient also far from the heading")};
  RealParameter tilt_cost_{owner_, real("tilt_cost", "", 0.0, at_least(0.0),
                                        "weight of 1 / max(cos tilt, 0.1) - 1, subtracted from the "
                                        "reward: a cost of large tilts")};
};

}  // namespace skybody::task_kit
