// Follows a trajectory by a linear-quadratic regulator about hover. Its gains are computed from
// weights when the scenario is loaded. Chain `ctbt` or `ctbr` next.
//
// With x to the front, pitch turns thrust g towards x: the errors of x, its velocity, pitch and
// pitch rate are a chain of four integrators driven by the pitch acceleration. y and roll form the
// same chain. Height (driven by thrust) and heading (driven by yaw acceleration) are chains of two.
// With rates as commands (ctbr), the chains are one integrator shorter.
//
// The feedback (k1, k2, k3, k4) of such a chain is split into guidance, pitch_c = -(k1 x + k2 v) /
// k3, and an attitude loop, -k3 (pitch - pitch_c) - k4 rate. To first order about hover this equals
// the linear law, and it is valid for any attitude and heading.
#include "controllers/common/guidance.h"
#include "controllers/common/tracking.h"
#include "controllers/common/trajectory.h"
#include "controllers/lqr/riccati.h"

namespace skybody {
namespace {

/// Bandwidth of the rate loop with default weights [rad/s].
constexpr double kRateGain = 25.0;

class Lqr : public Controller {
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
    limits_.configure(setup);
    report_.configure(setup, 0);
    setup.buffer(1);
    solve(control::gravity_of(setup));
    slow_down(setup, robot);
    trajectory_.configure(setup);
    setup.output(gives_torque_ ? Signal::kCtbt : Signal::kCtbr, 4);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(base_);
    const ReferencePoint<Real> reference = reference_point(input);
    const Vec3<Real> z = body_z(base.rotation);
    const Vec3<Real> feedback = times(gains_.position, reference.position - base.position) +
                                times(gains_.velocity, reference.velocity - base.velocity);
    const Vec3<Real> setpoint = feedback + drag_.acceleration(reference, z);
    const Vec3<Real> held = limits_.held(setpoint), thrust = limits_.thrust_for(held);
    report_.note(control::differs(held, setpoint), buffer);
    output.set(0, max(Real(0.0), mass_ * dot(thrust, z)));

    const auto track = control::tracking(error_, base, thrust, reference, gives_torque_);
    const Vec3<Real> rate = track.rates + times(gains_.attitude, track.error);
    if (!gives_torque_) {
      output.set(1, rate);
      return;
    }
    const Vec3<Real>& w = base.angular_velocity;
    const Vec3<Real> acceleration = track.acceleration + times(gains_.rate, rate - w);
    output.set(1, torque_for_(w, acceleration) + drag_.moment(reference, base.rotation));
  }

 private:
  struct Gains {
    Vec3<double> position, velocity;  ///< acceleration per error, W axes [1/s^2, 1/s]
    Vec3<double> attitude, rate;      ///< rate and angular acceleration per error, B axes [1/s]
  };

  template <class Real>
  static SKYBODY_INLINE Vec3<Real> times(const Vec3<double>& gain, const Vec3<Real>& error) {
    return {gain.x * error.x, gain.y * error.y, gain.z * error.z};
  }

  void solve(double gravity) {
    // Pitch (about y) moves x; roll (about x) moves y.
    const Lateral x = lateral(gravity, 0, 1), y = lateral(gravity, 1, 0);
    const Eigen::VectorXd height = control::chain_gain(
        {1.0}, {position_weight_.value(2), velocity_weight_.value(2)}, thrust_weight_.value());
    gains_ = {{x.position, y.position, height(0)},
              {x.velocity, y.velocity, height(1)},
              {y.attitude, x.attitude, 0.0},
              {y.rate, x.rate, 0.0}};
    if (gives_torque_) {
      const Eigen::VectorXd yaw = control::chain_gain(
          {1.0}, {attitude_weight_.value(2), rate_weight_.value(2)}, torque_weight_.value(2));
      gains_.attitude.z = yaw(0) / yaw(1);
      gains_.rate.z = yaw(1);
    } else {
      gains_.attitude.z =
          control::chain_gain({}, {attitude_weight_.value(2)}, rate_weight_.value(2))(0);
    }
  }

  struct Lateral {
    double position, velocity, attitude, rate;
  };

  /// @param along  axis of the motion in W
  /// @param about  axis of B of the corresponding tilt
  Lateral lateral(double gravity, int along, int about) const {
    std::vector<double> steps = {1.0, gravity};
    std::vector<double> weights = {position_weight_.value(along), velocity_weight_.value(along),
                                   attitude_weight_.value(about)};
    double input = rate_weight_.value(about);
    if (gives_torque_) {
      steps.push_back(1.0);
      weights.push_back(input);
      input = torque_weight_.value(about);
    }
    const Eigen::VectorXd k = control::chain_gain(steps, weights, input);
    return {gravity * k(0) / k(2), gravity * k(1) / k(2), gives_torque_ ? k(2) / k(3) : k(2),
            gives_torque_ ? k(3) : 0.0};
  }

  /// Slows the motion down if the rotors are slow and all weights are defaults.
  void slow_down(const Setup& setup, int robot) {
    const bool is_own = position_weight_.is_given() || velocity_weight_.is_given() ||
                        attitude_weight_.is_given() || rate_weight_.is_given() ||
                        thrust_weight_.is_given() || torque_weight_.is_given();
    if (is_own) return;
    const double share = control::lag_share(setup, robot, kRateGain);
    gains_.position *= share * share;
    gains_.velocity *= share;
    gains_.attitude *= share;
    gains_.rate *= share;
  }

  static RealsSpec weight(const char* name, const char* unit, std::vector<double> values,
                          const char* doc) {
    return {.name = name, .unit = unit, .values = std::move(values), .min = 1e-9, .doc = doc};
  }

  TextParameter output_{this,
                        {.name = "output",
                         .value = "ctbt",
                         .choices = {"ctbt", "ctbr"},
                         .doc = "output: torques, or rates for `ctbr`"}};
  RealsParameter position_weight_{this, weight("position_weight", "1/m^2", {40.0, 40.0, 60.0},
                                               "weight of position errors, W axes")};
  RealsParameter velocity_weight_{this, weight("velocity_weight", "s^2/m^2", {10.0, 10.0, 10.0},
                                               "weight of velocity errors, W axes")};
  RealsParameter attitude_weight_{this, weight("attitude_weight", "1/rad^2", {80.0, 80.0, 10.0},
                                               "weight of attitude errors, B axes")};
  RealsParameter rate_weight_{
      this, weight("rate_weight", "s^2/rad^2", {1.0, 1.0, 0.5},
                   "weight of rate errors, B axes; ctbr: of the commanded rates")};
  RealParameter thrust_weight_{this,
                               {.name = "thrust_weight",
                                .unit = "s^4/m^2",
                                .value = 0.7,
                                .min = 1e-9,
                                .doc = "weight of thrust per mass"}};
  RealsParameter torque_weight_{this, weight("torque_weight", "s^4/rad^2", {0.005, 0.005, 0.01},
                                             "ctbt: weight of angular acceleration, B axes")};
  control::AccelerationLimits limits_{this, control::kTrajectoryLimits};
  control::LimitReport report_;
  TextParameter error_word_{this,
                            {.name = "error",
                             .value = "quaternion",
                             .choices = {"quaternion", "se3", "tilt_priority"},
                             .doc = "form of the attitude error"}};
  control::DragFeedforward drag_{this};
  control::TrajectoryInput trajectory_{this};

  control::AttitudeError error_ = control::AttitudeError::kQuaternion;
  bool gives_torque_ = true;
  int base_ = 0;
  double mass_ = 0.0;
  control::AngularAccelerationToTorque torque_for_;
  Gains gains_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Lqr, "lqr", "1.0.0",
               "Follows a trajectory by a linear-quadratic regulator; output: ctbt or ctbr.");
