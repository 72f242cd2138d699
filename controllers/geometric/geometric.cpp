// Follows a trajectory on SE(3): thrust along the body's z axis, torque or rates by the attitude
// error, with feed-forward of the trajectory's acceleration, jerk and snap. Chain `ctbt` or `ctbr`.
#include "controllers/common/guidance.h"
#include "controllers/common/tracking.h"
#include "controllers/common/trajectory.h"

namespace skybody {
namespace {

/// Default gain of the rate loop, the fastest loop [rad/s].
constexpr double kRateGain = 22.0;

class Geometric : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    mass_ = control::total_mass(setup, robot);
    torque_for_.configure(setup.bodies()[base_]);
    drag_.configure(setup, robot);
    error_ = control::attitude_error_of(error_word_.value());
    gives_torque_ = output_.value() == "ctbt";
    const double share = control::lag_share(setup, robot, kRateGain);
    attitude_share_ = attitude_gain_.is_given() ? 1.0 : share;
    rate_share_ = rate_gain_.is_given() ? 1.0 : share;
    guidance_.configure(setup, share);
    trajectory_.configure(setup);
    setup.output(gives_torque_ ? Signal::kCtbt : Signal::kCtbr, 4);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(base_);
    const ReferencePoint<Real> reference = reference_point(input);
    const Vec3<Real> z = body_z(base.rotation);
    const Vec3<Real> thrust = specific_thrust(env, base, reference, z, buffer);
    output.set(0, max(Real(0.0), mass_ * dot(thrust, z)));

    const auto track = control::tracking(error_, base, thrust, reference, gives_torque_);
    const Vec3<Real> rate =
        track.rates +
        multiply_elements(control::shared(attitude_gain_.vec3(env), attitude_share_), track.error);
    if (!gives_torque_) {
      output.set(1, rate);
      return;
    }
    const Vec3<Real>& w = base.angular_velocity;
    const Vec3<Real> acceleration =
        track.acceleration +
        multiply_elements(control::shared(rate_gain_.vec3(env), rate_share_), rate - w);
    output.set(1, torque_for_(w, acceleration) + drag_.moment(reference, base.rotation));
  }

 private:
  /// Specific thrust of the rotors, W axes [m/s^2].
  /// @param z  z axis of B in W axes
  template <class Real>
  SKYBODY_INLINE Vec3<Real> specific_thrust(const EnvView<Real>& env, const BodyMotion<Real>& base,
                                            const ReferencePoint<Real>& reference,
                                            const Vec3<Real>& z, Values<Real> buffer) const {
    const Vec3<Real> setpoint = guidance_.setpoint(env, reference.position - base.position,
                                                   base.velocity - reference.velocity,
                                                   drag_.acceleration(reference, z), buffer);
    return guidance_.thrust(setpoint, buffer);
  }

  TextParameter output_{this,
                        {.name = "output",
                         .value = "ctbt",
                         .choices = {"ctbt", "ctbr"},
                         .doc = "output: torques, or rates for `ctbr`"}};
  control::Guidance guidance_{this, {6.0, 6.0, 9.0}, {4.0, 4.0, 5.4}, control::kTrajectoryLimits};
  RealsParameter attitude_gain_{this,
                                {.name = "attitude_gain",
                                 .unit = "1/s",
                                 .values = {9.0, 9.0, 3.0},
                                 .min = 0.0,
                                 .doc = "rate per attitude error, base axes",
                                 .randomizable = true}};
  RealsParameter rate_gain_{this,
                            {.name = "rate_gain",
                             .unit = "1/s",
                             .values = {kRateGain, kRateGain, 9.0},
                             .min = 0.0,
                             .doc = "ctbt: angular acceleration per rate error, base axes",
                             .randomizable = true}};
  TextParameter error_word_{this,
                            {.name = "error",
                             .value = "se3",
                             .choices = {"se3", "quaternion", "tilt_priority"},
                             .doc = "form of the attitude error"}};
  control::DragFeedforward drag_{this};
  control::TrajectoryInput trajectory_{this};

  control::AttitudeError error_ = control::AttitudeError::kSe3;
  bool gives_torque_ = true;
  int base_ = 0;
  double mass_ = 0.0;
  double attitude_share_ = 1.0, rate_share_ = 1.0;
  control::AngularAccelerationToTorque torque_for_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Geometric, "geometric", "1.0.0",
               "Follows a trajectory on SE(3); output: ctbt or ctbr.");
