// Position and heading, or a trajectory: a PD or PID with gravity and the trajectory's acceleration
// fed forward. Chain `attitude`, then `ctbr`.
#include "controllers/common/flatness.h"
#include "controllers/common/guidance.h"
#include "controllers/common/trajectory.h"

namespace skybody {
namespace {

class Position : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    mass_ = control::total_mass(setup, robot);
    guidance_.configure(setup);
    box_.configure();
    follows_ = signal_.value() == "trajectory";
    if (points_.is_given() && !follows_) {
      refuse(
          "`points` is given, but `signal` is `position`, which has none: leave it out, or set "
          "`signal: trajectory`");
    }
    if (follows_) {
      control::declare_trajectory(setup, static_cast<int>(points_.value()),
                                  {box_.low(), box_.high()});
      setup.output(Signal::kAttitude, 8);
      return;
    }
    box_.declare_position(setup);
    setup.output(Signal::kAttitude, 5);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(base_);
    if (follows_) {
      follow(env, base, reference_point(input), output, buffer);
      return;
    }
    const Vec3<Real> target = box_.clamped(input.vec3(0));
    const Vec3<Real> force = guidance_.limits().thrust(
        guidance_.setpoint(env, target - base.position, base.velocity, buffer), buffer);
    const Vec3<Real> up = force / norm(force);
    output.set(0, max(Real(0.0), mass_ * dot(force, body_z(base.rotation))));
    output.set(1, control::tilted(up, sincos(0.5 * wrap_angle(input[3]))));
  }

 private:
  /// A trajectory is not clamped to the box, which is the range of actions.
  template <class Real>
  SKYBODY_INLINE void follow(const EnvView<Real>& env, const BodyMotion<Real>& base,
                             const ReferencePoint<Real>& reference, Values<Real> output,
                             Values<Real> buffer) const {
    const Vec3<Real> force = guidance_.limits().thrust(
        guidance_.setpoint(env, reference.position - base.position,
                           base.velocity - reference.velocity, reference.acceleration, buffer),
        buffer);
    const auto flat = control::flat_attitude(force, reference.yaw);
    output.set(0, max(Real(0.0), mass_ * dot(force, body_z(base.rotation))));
    output.set(1, flat.rotation);
    output.set(5, control::flat_rates(flat, reference.jerk, reference.yaw_rate).value);
  }

  TextParameter signal_{this,
                        choice("signal", "position", {"position", "trajectory"},
                               "input; a trajectory's acceleration and jerk are fed forward")};
  control::Guidance guidance_{this, {4.0, 4.0, 9.0}, {3.2, 3.2, 5.4}, {}};
  control::PositionBox box_{this};
  IntegerParameter points_{
      this, integer("points", "", 1, between(1, 1000),
                    "trajectory: points of the trajectory; only the first one is used")};

  bool follows_ = false;
  int base_ = 0;
  double mass_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Position, "position", "1.0.0",
               "Controls position [m] and yaw [rad], or follows a trajectory; output: attitude.");
