// Parts that the laws on SE(3) share: they follow a trajectory by a specific thrust and, about it,
// body rates (`ctbr`) or a torque (`ctbt`).
#pragma once

#include "controllers/common/guidance.h"
#include "controllers/common/tracking.h"
#include "controllers/common/trajectory.h"

namespace skybody::control {

/// The reference and the vehicle at a step.
template <class Real>
struct Followed {
  ReferencePoint<Real> reference;
  BodyMotion<Real> base;
  Vec3<Real> z;  ///< z axis of B in W axes

  SKYBODY_INLINE Vec3<Real> offset() const { return reference.position - base.position; }
  SKYBODY_INLINE Vec3<Real> slip() const { return reference.velocity - base.velocity; }
};

/// Declared as a member of the controller `owner`, after its own parameters.
class TrajectoryLaw {
 public:
  /// @param error  default form of the attitude error
  explicit TrajectoryLaw(Plugin* owner, const char* error = "quaternion")
      : error_(owner, error), drag_(owner), trajectory_(owner) {}

  /// Declares input and output.
  void configure(const Setup& setup, bool gives_torque) {
    const int robot = setup.robot();
    gives_torque_ = gives_torque;
    base_ = base_of(setup, robot);
    mass_ = total_mass(setup, robot);
    torque_for_.configure(setup.bodies()[base_]);
    drag_.configure(setup, robot);
    error_.configure();
    trajectory_.configure(setup);
    setup.output(gives_torque ? Signal::kCtbt : Signal::kCtbr, 4);
  }

  bool gives_torque() const { return gives_torque_; }

  template <class Real>
  SKYBODY_INLINE Followed<Real> followed(const EnvView<Real>& env, ConstValues<Real> input) const {
    const BodyMotion<Real> base = env.body(base_);
    return {reference_point(input), base, body_z(base.rotation)};
  }
  /// The reference's acceleration plus the compensation of drag [m/s^2].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> forward(const Followed<Real>& now) const {
    return drag_.acceleration(now.reference, now.z);
  }

  /// Writes the collective thrust of a specific thrust [m/s^2], and returns the attitude loop's
  /// errors and feed-forward about it.
  template <class Real>
  SKYBODY_INLINE Tracking<Real> push(const Followed<Real>& now, const Vec3<Real>& thrust,
                                     Values<Real> output) const {
    output.set(0, max(Real(0.0), mass_ * dot(thrust, now.z)));
    return tracking(error_.form(), now.base, thrust, now.reference, gives_torque_);
  }
  /// Writes the torque for an angular acceleration [rad/s^2].
  template <class Real>
  SKYBODY_INLINE void turn(const Followed<Real>& now, const Vec3<Real>& acceleration,
                           Values<Real> output) const {
    output.set(1, torque_for_(now.base.angular_velocity, acceleration) +
                      drag_.moment(now.reference, now.base.rotation));
  }

 private:
  AttitudeErrorChoice error_;
  DragFeedforward drag_;
  TrajectoryInput trajectory_;
  AngularAccelerationToTorque torque_for_;
  bool gives_torque_ = true;
  int base_ = 0;
  double mass_ = 0.0;
};

/// The parameter `output` of laws that give torques or rates.
inline TextSpec torque_or_rates() {
  return choice("output", "ctbt", {"ctbt", "ctbr"}, "output: torques, or rates for `ctbr`");
}

}  // namespace skybody::control
