// Velocity in world axes and yaw rate to a desired acceleration. Chain `acceleration`, then
// `force`.
#include "controllers/common/guidance.h"

namespace skybody {
namespace {

class VelocityTracking : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Real yaw;  ///< desired heading [rad], in [-pi, pi]
  };

  void configure(const Setup& setup) override {
    base_ = control::base_of(setup, setup.robot());
    dt_ = setup.dt();
    share_ = gain_.is_given() ? 1.0 : control::lag_share(setup, setup.robot(), kRateLoop);
    limits_.configure(setup);
    integral_.configure(setup);
    report_.configure(setup, integral_.words());
    setup.buffer(integral_.words() + 1);
    const Vec3<double> v = max_velocity_.vec3();
    const double rate = max_yaw_rate_.value();
    setup.input(Signal::kVelocityTracking, {-v.x, -v.y, -v.z, -rate}, {v.x, v.y, v.z, rate});
    setup.output(Signal::kAcceleration, 4);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    state.yaw = yaw(env.body(base_).rotation);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
               Values<Real> output, Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(base_);
    const Vec3<Real> velocity = control::clamp_symmetric(input.vec3(0), max_velocity_.vec3());
    const Vec3<Real> error = velocity - base.velocity;
    const Vec3<Real> setpoint = integral_.added(
        multiply_elements(gain_.vec3(env) * Real(share_), error), error, limits_, buffer);
    const Vec3<Real> held = limits_.held(setpoint);
    output.set(0, held);
    report_.note(
        logical_or(control::differs(velocity, input.vec3(0)), control::differs(held, setpoint)),
        buffer);
    state.yaw = led(state.yaw, input[3], yaw(base.rotation));
    output.set(3, state.yaw);
  }

 private:
  /// Bandwidth of the rate loop that the default gain assumes [rad/s].
  static constexpr double kRateLoop = 20.0;

  /// The desired heading after one step. It leads the body's heading by at most `max_yaw_lead`, so
  /// that a slow body does not keep turning long after the command has ended.
  template <class Real>
  SKYBODY_INLINE Real led(const Real& now, const Real& rate, const Real& heading) const {
    const Real held = clamp(rate, -max_yaw_rate_.value(), max_yaw_rate_.value());
    const Real ahead = wrap_angle((now + held * dt_) - heading);
    return wrap_angle(heading + clamp(ahead, -max_lead_.value(), max_lead_.value()));
  }

  RealsParameter gain_{this, randomizable(reals("gain", "1/s", {3.0, 3.0, 4.0}, at_least(0.0),
                                                "acceleration per velocity error, W axes"))};
  control::Integral integral_{this, "1/s^2",
                              "acceleration per integral of velocity error, W axes; 0: none"};
  control::AccelerationLimits limits_{this, control::kTrajectoryLimits};
  control::LimitReport report_;
  RealsParameter max_velocity_{this,
                               reals("max_velocity", "m/s", {5.0, 5.0, 3.0}, at_least(1e-6),
                                     "velocities for action +1; commands are clamped to them")};
  RealParameter max_yaw_rate_{this, real("max_yaw_rate", "rad/s", 2.0, at_least(1e-6),
                                         "yaw rate for action +1; commands are clamped to it")};
  RealParameter max_lead_{this, real("max_yaw_lead", "rad", 0.5, between(1e-3, 3.0),
                                     "largest lead of the desired heading over the body's")};

  int base_ = 0;
  double dt_ = 0.0, share_ = 1.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::VelocityTracking, "velocity_tracking", "1.0.0",
               "Controls velocity in world axes [m/s] and yaw rate [rad/s]; output: acceleration.");
