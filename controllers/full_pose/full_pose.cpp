// Independent position and attitude control for vehicles that can push in all directions: force and
// torque of the whole robot. Chain `tilt_allocation`, or `mixer` with `signal: wrench`.
#include "controllers/common/attitude_error.h"
#include "controllers/common/composite_body.h"
#include "controllers/common/position_box.h"

namespace skybody {
namespace {

class FullPose : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    gravity_ = control::gravity_of(setup);
    const control::CompositeBody all = control::assembly_of(setup, robot);
    mass_ = all.mass;
    com_ = all.com;
    inertia_ = all.inertia;
    box_.configure();
    box_.declare_pose(setup);
    setup.output(Signal::kWrench, 6);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    const BodyMotion<Real> base = env.body(base_);
    const Vec3<Real>& w = base.angular_velocity;
    const Vec3<Real> com = control::lift<Real>(com_);
    // The force acts at the centre of mass, so damping uses that point's velocity, which excludes
    // rotation. The reference position is the origin's.
    const Vec3<Real> velocity = base.velocity + rotate(base.rotation, cross(w, com));
    Vec3<Real> push = multiply_elements(kp_.vec3(env), limited(input.vec3(0) - base.position)) -
                      multiply_elements(kd_.vec3(env), velocity);
    push.z += gravity_;
    output.set(0, rotate_inverse(base.rotation, push) * Real(mass_));

    const Quat<Real> left = conjugate(base.rotation) * control::unit_or_identity(input.quat(3));
    const Vec3<Real> turn =
        control::clamp_symmetric(control::attitude_error(control::AttitudeError::kQuaternion, left),
                                 {max_turn_.value(), max_turn_.value(), max_turn_.value()});
    const Vec3<Real> setpoint = multiply_elements(attitude_gain_.vec3(env), turn) -
                                multiply_elements(rate_gain_.vec3(env), w);
    const SymMat3<Real> j = control::lift<Real>(inertia_);
    output.set(3, j * setpoint + cross(w, j * w));
  }

 private:
  /// Position error, limited for the feedback.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> limited(const Vec3<Real>& error) const {
    const Real size = norm(error), most(max_error_.value());
    const auto beyond = size > most;
    return error * select(beyond, most / select(beyond, size, Real(1.0)), Real(1.0));
  }

  RealsParameter kp_{this, randomizable(reals("kp", "1/s^2", {4.0, 4.0, 6.0}, at_least(0.0),
                                              "acceleration per position error, W axes"))};
  RealsParameter kd_{this, randomizable(reals("kd", "1/s", {3.2, 3.2, 4.4}, at_least(0.0),
                                              "acceleration per velocity, W axes"))};
  RealsParameter attitude_gain_{
      this, randomizable(reals("attitude_gain", "1/s^2", {36.0, 36.0, 20.0}, at_least(0.0),
                               "angular acceleration per angle of error, base axes"))};
  RealsParameter rate_gain_{this,
                            randomizable(reals("rate_gain", "1/s", {10.0, 10.0, 8.0}, at_least(0.0),
                                               "angular acceleration per rate, base axes"))};
  RealParameter max_error_{this, real("max_error", "m", 1.0, at_least(1e-6),
                                      "limit of the position error in the feedback")};
  RealParameter max_turn_{this,
                          real("max_turn", "rad", 0.5, at_least(1e-6),
                               "limit of the attitude error in the feedback, about each axis")};
  control::PositionBox box_{this};

  int base_ = 0;
  double mass_ = 0.0, gravity_ = 0.0;
  Vec3<double> com_{};
  SymMat3<double> inertia_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::FullPose, "full_pose", "1.0.0",
               "Controls position [m] and attitude independently; output: the robot's wrench.");
