// The input of controllers that follow a trajectory.
#pragma once

#include <vector>

#include "controllers/common/position_box.h"
#include "controllers/common/vehicle.h"

namespace skybody::control {

/// Ranges of the actions if a policy gives the trajectory.
struct TrajectoryRange {
  Vec3<double> low, high;     ///< position, W [m]
  double velocity = 2.0;      ///< each axis [m/s]
  double acceleration = 2.0;  ///< each axis [m/s^2]
  double yaw_rate = 1.0;      ///< [rad/s]
};

/// Declares a trajectory of `points` points. Jerk and snap of actions are 0.
inline void declare_trajectory(const Setup& setup, int points, const TrajectoryRange& range) {
  std::vector<double> low, high;
  const double v = range.velocity, a = range.acceleration;
  for (int i = 0; i < points; ++i) {
    low.insert(low.end(), {range.low.x, range.low.y, range.low.z, -v, -v, -v, -a, -a, -a, 0.0, 0.0,
                           0.0, 0.0, 0.0, 0.0, -kPi, -range.yaw_rate});
    high.insert(high.end(), {range.high.x, range.high.y, range.high.z, v, v, v, a, a, a, 0.0, 0.0,
                             0.0, 0.0, 0.0, 0.0, kPi, range.yaw_rate});
  }
  setup.input(Signal::kTrajectory, low, high);
}

/// Feed-forward of the rotors' drag at the reference's velocity, nominal values.
class DragFeedforward {
 public:
  explicit DragFeedforward(Plugin* owner)
      : on_(owner, boolean("drag", true,
                           "feed forward the rotors' nominal drag at the reference's velocity")) {}

  void configure(const Setup& setup, int robot) {
    if (!on_.value()) return;
    drag_ = hover_drag(setup, robot);
    moment_ = total_mass(setup, robot) * drag_.per_mass * drag_.height;
  }

  /// The reference's acceleration plus the compensation of the drag force [m/s^2].
  /// @param z  z axis of B in W axes: rotors drag across it
  template <class Real>
  SKYBODY_INLINE Vec3<Real> acceleration(const ReferencePoint<Real>& reference,
                                         const Vec3<Real>& z) const {
    const Vec3<Real>& v = reference.velocity;
    return reference.acceleration + (v - z * dot(z, v)) * Real(drag_.per_mass);
  }

  /// Compensation of the drag's moment [N m], B axes. Drag acts at the hubs, above the centre of
  /// mass.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> moment(const ReferencePoint<Real>& reference,
                                   const Quat<Real>& rotation) const {
    const Vec3<Real> v = rotate_inverse(rotation, reference.velocity);
    return {-(v.y * moment_), v.x * moment_, Real(0.0)};
  }

 private:
  BooleanParameter on_;
  HoverDrag drag_;
  double moment_ = 0.0;  ///< per velocity [N s]
};

/// Parameters of a controller that follows only trajectories.
class TrajectoryInput {
 public:
  explicit TrajectoryInput(Plugin* owner)
      : points_(owner, integer("points", "", 1, between(1, 1000),
                               "points of the trajectory; only the first one is used")),
        box_(owner) {}

  /// @throws std::runtime_error if the box's minimum is not below its maximum
  void configure(const Setup& setup) const {
    box_.configure();
    declare_trajectory(setup, static_cast<int>(points_.value()), {box_.low(), box_.high()});
  }

 private:
  IntegerParameter points_;
  PositionBox box_;
};

}  // namespace skybody::control
