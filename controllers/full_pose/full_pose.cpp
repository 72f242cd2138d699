// Independent position and attitude control for vehicles that can push in all directions: force and
// torque of the whole robot. Chain `tilt_allocation`, or `mixer` with `signal: wrench`.
#include "controllers/common/attitude_error.h"
#include "controllers/common/composite_body.h"

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
    const Vec3<double> low = position_min_.vec3(), high = position_max_.vec3();
    control::require_order("position_min[0]", low.x, "position_max[0]", high.x);
    control::require_order("position_min[1]", low.y, "position_max[1]", high.y);
    control::require_order("position_min[2]", low.z, "position_max[2]", high.z);
    setup.input(Signal::kPose, {low.x, low.y, low.z, -1.0, -1.0, -1.0, -1.0},
                {high.x, high.y, high.z, 1.0, 1.0, 1.0, 1.0});
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

    const Quat<Real> left = conjugate(base.rotation) * attitude(input.quat(3));
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

  template <class Real>
  static SKYBODY_INLINE Quat<Real> attitude(const Quat<Real>& setpoint) {
    const Real size = squared_norm(setpoint);
    const auto usable = size > 1e-12;
    const Real scale = 1.0 / sqrt(select(usable, size, Real(1.0)));
    const Quat<Real> unit{setpoint.w * scale, setpoint.x * scale, setpoint.y * scale,
                          setpoint.z * scale};
    return select(usable, unit, Quat<Real>::identity());
  }

  RealsParameter kp_{this,
                     {.name = "kp",
                      .unit = "1/s^2",
                      .values = {4.0, 4.0, 6.0},
                      .min = 0.0,
                      .doc = "acceleration per position error, W axes",
                      .randomizable = true}};
  RealsParameter kd_{this,
                     {.name = "kd",
                      .unit = "1/s",
                      .values = {3.2, 3.2, 4.4},
                      .min = 0.0,
                      .doc = "acceleration per velocity, W axes",
                      .randomizable = true}};
  RealsParameter attitude_gain_{this,
                                {.name = "attitude_gain",
                                 .unit = "1/s^2",
                                 .values = {36.0, 36.0, 20.0},
                                 .min = 0.0,
                                 .doc = "angular acceleration per angle of error, base axes",
                                 .randomizable = true}};
  RealsParameter rate_gain_{this,
                            {.name = "rate_gain",
                             .unit = "1/s",
                             .values = {10.0, 10.0, 8.0},
                             .min = 0.0,
                             .doc = "angular acceleration per rate, base axes",
                             .randomizable = true}};
  RealParameter max_error_{this,
                           {.name = "max_error",
                            .unit = "m",
                            .value = 1.0,
                            .min = 1e-6,
                            .doc = "limit of the position error in the feedback"}};
  RealParameter max_turn_{this,
                          {.name = "max_turn",
                           .unit = "rad",
                           .value = 0.5,
                           .min = 1e-6,
                           .doc = "limit of the attitude error in the feedback, about each axis"}};
  RealsParameter position_min_{this,
                               {.name = "position_min",
                                .unit = "m",
                                .values = {-5.0, -5.0, 0.5},
                                .doc = "position for action -1 (W)"}};
  RealsParameter position_max_{this,
                               {.name = "position_max",
                                .unit = "m",
                                .values = {5.0, 5.0, 3.0},
                                .doc = "position for action +1 (W)"}};

  int base_ = 0;
  double mass_ = 0.0, gravity_ = 0.0;
  Vec3<double> com_{};
  SymMat3<double> inertia_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::FullPose, "full_pose", "1.0.0",
               "Controls position [m] and attitude independently; output: the robot's wrench.");
