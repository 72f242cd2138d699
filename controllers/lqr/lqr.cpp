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
#include "controllers/common/trajectory_law.h"
#include "controllers/lqr/riccati.h"

namespace skybody {
namespace {

/// Bandwidth of the rate loop with default weights [rad/s].
constexpr double kRateGain = 25.0;

class Lqr : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    law_.configure(setup, output_.value() == "ctbt");
    limits_.configure(setup);
    solve(control::gravity_of(setup));
    slow_down(setup, setup.robot());
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const control::Followed<Real> now = law_.followed(env, input);
    const Vec3<Real> feedback =
        times(gains_.position, now.offset()) + times(gains_.velocity, now.slip());
    const auto track = law_.push(now, limits_.thrust(feedback + law_.forward(now), buffer), output);
    const Vec3<Real> rate = track.rates + times(gains_.attitude, track.error);
    if (!law_.gives_torque()) {
      output.set(1, rate);
      return;
    }
    law_.turn(now, track.acceleration + times(gains_.rate, rate - now.base.angular_velocity),
              output);
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
    if (law_.gives_torque()) {
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
    if (law_.gives_torque()) {
      steps.push_back(1.0);
      weights.push_back(input);
      input = torque_weight_.value(about);
    }
    const Eigen::VectorXd k = control::chain_gain(steps, weights, input);
    return {gravity * k(0) / k(2), gravity * k(1) / k(2), law_.gives_torque() ? k(2) / k(3) : k(2),
            law_.gives_torque() ? k(3) : 0.0};
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

  TextParameter output_{this, control::torque_or_rates()};
  RealsParameter position_weight_{this, weight("position_weight", "1/m^2", {40.0, 40.0, 60.0},
                                               "weight of position errors, W axes")};
  RealsParameter velocity_weight_{this, weight("velocity_weight", "s^2/m^2", {10.0, 10.0, 10.0},
                                               "weight of velocity errors, W axes")};
  RealsParameter attitude_weight_{this, weight("attitude_weight", "1/rad^2", {80.0, 80.0, 10.0},
                                               "weight of attitude errors, B axes")};
  RealsParameter rate_weight_{
      this, weight("rate_weight", "s^2/rad^2", {1.0, 1.0, 0.5},
                   "weight of rate errors, B axes; ctbr: of the commanded rates")};
  RealParameter thrust_weight_{
      this, real("thrust_weight", "s^4/m^2", 0.7, at_least(1e-9), "weight of thrust per mass")};
  RealsParameter torque_weight_{this, weight("torque_weight", "s^4/rad^2", {0.005, 0.005, 0.01},
                                             "ctbt: weight of angular acceleration, B axes")};
  control::ReportedLimits limits_{this, control::kTrajectoryLimits};
  control::TrajectoryLaw law_{this};

  Gains gains_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Lqr, "lqr", "1.0.0",
               "Follows a trajectory by a linear-quadratic regulator; output: ctbt or ctbr.");
