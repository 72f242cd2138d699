// Follows a trajectory in sliding mode: position and attitude are driven onto surfaces on which
// their errors decay, by switching terms smoothed in a boundary layer. Chain `ctbt` next.
#include "controllers/common/guidance.h"
#include "controllers/common/tracking.h"
#include "controllers/common/trajectory.h"

namespace skybody {
namespace {

/// Bandwidth of the attitude loop inside its boundary layer with default values [rad/s].
constexpr double kRateGain = 22.0;

class SlidingMode : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    mass_ = control::total_mass(setup, robot);
    torque_for_.configure(setup.bodies()[base_]);
    drag_.configure(setup, robot);
    error_ = control::attitude_error_of(error_word_.value());
    const double share = control::lag_share(setup, robot, kRateGain);
    position_.configure(share);
    attitude_.configure(share);
    limits_.configure(setup);
    report_.configure(setup, 0);
    setup.buffer(1);
    trajectory_.configure(setup);
    setup.output(Signal::kCtbt, 4);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(base_);
    const ReferencePoint<Real> reference = reference_point(input);
    const Vec3<Real> z = body_z(base.rotation);
    const Vec3<Real> push = position_.drive(env, reference.position - base.position,
                                            reference.velocity - base.velocity);
    const Vec3<Real> setpoint = push + drag_.acceleration(reference, z);
    const Vec3<Real> held = limits_.held(setpoint), thrust = limits_.thrust_for(held);
    report_.note(control::differs(held, setpoint), buffer);
    output.set(0, max(Real(0.0), mass_ * dot(thrust, z)));

    const auto track = control::tracking(error_, base, thrust, reference, true);
    const Vec3<Real>& w = base.angular_velocity;
    const Vec3<Real> turn = attitude_.drive(env, track.error, track.rates - w);
    output.set(1,
               torque_for_(w, track.acceleration + turn) + drag_.moment(reference, base.rotation));
  }

 private:
  /// A surface s = de/dt + slope e, with e the remaining error, and the command that drives s to 0.
  class Surface {
   public:
    struct Names {
      const char *slope, *gain, *boundary, *gain_unit, *boundary_unit;
    };
    Surface(Plugin* owner, const Names& names, std::vector<double> slope, std::vector<double> gain,
            std::vector<double> boundary)
        : slope_(owner, {.name = names.slope,
                         .unit = "1/s",
                         .values = std::move(slope),
                         .min = 0.0,
                         .doc = "rate at which the error decays on the surface",
                         .randomizable = true}),
          gain_(owner, {.name = names.gain,
                        .unit = names.gain_unit,
                        .values = std::move(gain),
                        .min = 0.0,
                        .doc = "acceleration towards the surface outside the boundary layer",
                        .randomizable = true}),
          boundary_(owner, {.name = names.boundary,
                            .unit = names.boundary_unit,
                            .values = std::move(boundary),
                            .min = 1e-6,
                            .doc = "half the boundary layer's thickness"}) {}

    /// @param share  factor on default rates (lag_share)
    void configure(double share) {
      slope_share_ = slope_.is_given() ? 1.0 : share;
      // The slope within the layer is gain / boundary: a rate.
      gain_share_ = gain_.is_given() || boundary_.is_given() ? 1.0 : share;
      const Vec3<double> b = boundary_.vec3();
      per_boundary_ = {1.0 / b.x, 1.0 / b.y, 1.0 / b.z};
    }

    /// slope de/dt + gain sat(s / boundary)
    template <class Real>
    SKYBODY_INLINE Vec3<Real> drive(const EnvView<Real>& env, const Vec3<Real>& error,
                                    const Vec3<Real>& rate) const {
      const Vec3<Real> slope = slope_.vec3(env) * Real(slope_share_);
      const Vec3<Real> s = rate + multiply_elements(slope, error);
      const Vec3<Real> share = multiply_elements(s, control::lift<Real>(per_boundary_));
      return multiply_elements(slope, rate) +
             multiply_elements(gain_.vec3(env) * Real(gain_share_),
                               control::clamp_symmetric(share, {1.0, 1.0, 1.0}));
    }

   private:
    RealsParameter slope_, gain_, boundary_;
    double slope_share_ = 1.0, gain_share_ = 1.0;
    Vec3<double> per_boundary_{};
  };

  Surface position_{this,
                    {"position_slope", "position_gain", "position_boundary", "m/s^2", "m/s"},
                    {1.5, 1.5, 2.0},
                    {4.0, 4.0, 5.0},
                    {1.4, 1.4, 1.4}};
  Surface attitude_{this,
                    {"attitude_slope", "attitude_gain", "attitude_boundary", "rad/s^2", "rad/s"},
                    {6.0, 6.0, 3.0},
                    {48.0, 48.0, 12.0},
                    {3.0, 3.0, 2.0}};
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
  int base_ = 0;
  double mass_ = 0.0;
  control::AngularAccelerationToTorque torque_for_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::SlidingMode, "sliding_mode", "1.0.0",
               "Follows a trajectory in sliding mode; output: ctbt.");
