// Follows a trajectory on SE(3): thrust along the body's z axis, torque or rates by the attitude
// error, with feed-forward of the trajectory's acceleration, jerk and snap. Chain `ctbt` or `ctbr`.
#include "controllers/common/trajectory_law.h"

namespace skybody {
namespace {

/// Default gain of the rate loop, the fastest loop [rad/s].
constexpr double kRateGain = 22.0;

class Geometric : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const double share = control::lag_share(setup, setup.robot(), kRateGain);
    attitude_share_ = attitude_gain_.is_given() ? 1.0 : share;
    rate_share_ = rate_gain_.is_given() ? 1.0 : share;
    guidance_.configure(setup, share);
    law_.configure(setup, output_.value() == "ctbt");
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const control::Followed<Real> now = law_.followed(env, input);
    const Vec3<Real> setpoint = guidance_.setpoint(
        env, now.offset(), now.base.velocity - now.reference.velocity, law_.forward(now), buffer);
    const auto track = law_.push(now, guidance_.limits().thrust(setpoint, buffer), output);
    const Vec3<Real> rate =
        track.rates +
        multiply_elements(control::shared(attitude_gain_.vec3(env), attitude_share_), track.error);
    if (!law_.gives_torque()) {
      output.set(1, rate);
      return;
    }
    const Vec3<Real> acceleration =
        track.acceleration + multiply_elements(control::shared(rate_gain_.vec3(env), rate_share_),
                                               rate - now.base.angular_velocity);
    law_.turn(now, acceleration, output);
  }

 private:
  TextParameter output_{this, control::torque_or_rates()};
  control::Guidance guidance_{this, {6.0, 6.0, 9.0}, {4.0, 4.0, 5.4}, control::kTrajectoryLimits};
  RealsParameter attitude_gain_{
      this, randomizable(reals("attitude_gain", "1/s", {9.0, 9.0, 3.0}, at_least(0.0),
                               "rate per attitude error, base axes"))};
  RealsParameter rate_gain_{
      this, randomizable(reals("rate_gain", "1/s", {kRateGain, kRateGain, 9.0}, at_least(0.0),
                               "ctbt: angular acceleration per rate error, base axes"))};
  control::TrajectoryLaw law_{this, "se3"};

  double attitude_share_ = 1.0, rate_share_ = 1.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Geometric, "geometric", "1.0.0",
               "Follows a trajectory on SE(3); output: ctbt or ctbr.");
