// The smooth cost for training a policy. It is derived from the task's goal, so that every task
// with a goal is learned in the same way.
#pragma once

#include <cstdint>

#include "core/base/math/vec3.h"
#include "core/base/simd/isa.h"
#include "learn/hyperparameters.h"

namespace skybody::learn {

/// Cost of a body's point with position p and velocity v, the body's rates w and heading psi, and a
/// goal with the position g, velocity g' and heading psi_g, at the end of each transition:
///
///   sqrt(|v - v_g|^2 + 0.1^2) + 0.3 min(|g - p|, 1) + 0.5 (psi - psi_g)^2 + 0.02 |w|^2
///
/// where v_g = g' + (g - p) / |g - p| min(approach_rate |g - p|, approach_speed): far away fly
/// towards the goal at a fixed speed, close to it brake to the goal's own velocity. A cost of the
/// distance alone has no feasible optimum, and a policy that accelerates towards the goal at full
/// power tumbles. Each change of an action a between two transitions adds 0.1 |change|^2
/// (kSmoothness).
struct GoalCost {
  double approach_speed, approach_rate;
  static constexpr double kSmoothness = 0.1;
  static constexpr int kGoalRows = 7;

  Vec3<double> point;  ///< of the body, in its frame: the point that should reach the goal [m]

  GoalCost(const Hyperparameters& hyper, const Vec3<double>& goal_point)
      : approach_speed(hyper.approach_speed),
        approach_rate(hyper.approach_rate),
        point(goal_point) {}

  bool has_point() const { return point.x != 0.0 || point.y != 0.0 || point.z != 0.0; }

  /// Adds `weight` times the cost's derivatives, in a group of kGroupLanes lanes.
  /// @param motion    13 rows: the body's BodyState
  /// @param goal      kGoalRows: target position of the body's frame with its current rotation,
  ///        heading, velocity
  /// @param adjoints  13 rows, added to in `lanes`
  /// @param cost      1 row: added to in `lanes`
  /// @param distance  1 row, overwritten [m]
  void add(std::uint32_t lanes, double weight, const double* motion, const double* goal,
           double* adjoints, double* cost, double* distance, Isa isa) const;
};

}  // namespace skybody::learn
