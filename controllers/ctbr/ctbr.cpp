// Collective thrust and body rates: a rate PD, or ideal rates.
#include "controllers/common/thrust_torque.h"

namespace skybody {
namespace {

class Ctbr : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    control::ThrustTorqueState<Real> actuators;
    Vec3<Real> last_rate;     ///< [rad/s]
    Vec3<Real> acceleration;  ///< filtered difference of rates [rad/s^2]
  };

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    if (!pd_.value() && actuators_.is_by_rotors()) {
      refuse(
          "`pd: false` gives ideal rates past the rotors, but `apply` is `rotors`: set `apply: "
          "body`, or leave `pd` on");
    }
    actuators_.configure(setup, robot, "ctbr", pd_.value(), {0.0, 0.0, 0.0});
    dt_ = setup.dt();
    base_ = control::base_of(setup, robot);
    const BodyInfo& base = setup.bodies()[base_];
    inertia_ = control::inertia_of(base);
    first_inertia_ = base.first_param + SKYBODY_BODY_INERTIA;
    const double time = derivative_time_.value();
    derivative_share_ = time > 0.0 ? -expm1(-dt_ / time) : 1.0;
    const Vec3<double> rate = max_rate_.vec3();
    setup.input(Signal::kCtbr, {0.0, -rate.x, -rate.y, -rate.z},
                {actuators_.limits().thrust, rate.x, rate.y, rate.z});
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    actuators_.reset(env, state.actuators);
    state.last_rate = env.body(base_).angular_velocity;
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
               Values<Real> output) const {
    const Vec3<Real> rate = env.body(base_).angular_velocity;
    const Vec3<Real> reference = control::clamp_symmetric(input.vec3(1), max_rate_.vec3());
    const Vec3<Real> error = reference - rate;
    if (!pd_.value()) {
      const SymMat3<Real> j = inertia(env);
      const Vec3<Real> torque = j * (error / Real(dt_)) + cross(rate, j * rate);
      drive_ideal(input[0], torque, output);
      return;
    }
    const Vec3<Real> raw = (rate - state.last_rate) / Real(dt_);
    state.acceleration += (raw - state.acceleration) * Real(derivative_share_);
    state.last_rate = rate;
    const SymMat3<Real> j = control::lift<Real>(inertia_);
    const Vec3<Real> wanted = multiply_elements(kp_.vec3(env), error) -
                              multiply_elements(kd_.vec3(env), state.acceleration);
    const Vec3<Real> torque = (scaled_.value() ? j * wanted : wanted) + cross(rate, j * rate);
    actuators_.drive(env, state.actuators, input[0], torque, output);
  }

 private:
  /// The environment's own inertia.
  template <class Real>
  SKYBODY_INLINE SymMat3<Real> inertia(const EnvView<Real>& env) const {
    const int i = first_inertia_;
    return {env.param(i),     env.param(i + 1), env.param(i + 2),
            env.param(i + 3), env.param(i + 4), env.param(i + 5)};
  }

  /// No lag, and no limit on the torque.
  template <class Real>
  SKYBODY_INLINE void drive_ideal(const Real& thrust, const Vec3<Real>& torque,
                                  Values<Real> output) const {
    output.set(0, Vec3<Real>{Real(0.0), Real(0.0),
                             clamp(thrust, Real(0.0), Real(actuators_.limits().thrust))});
    output.set(3, torque);
  }

  control::ThrustTorque actuators_{this};
  BooleanParameter pd_{
      this, boolean("pd", true, "true: rate PD; false: ideal rates, reached in one physics step")};
  RealsParameter kp_{
      this, randomizable(reals("kp", "1/s", {20.0, 20.0, 8.0}, at_least(0.0),
                               "proportional gains; N m s/rad if inertia_scaled is false"))};
  RealsParameter kd_{
      this, randomizable(reals("kd", "", {0.1, 0.1, 0.1}, at_least(0.0),
                               "derivative gains; N m s^2/rad if inertia_scaled is false"))};
  BooleanParameter scaled_{
      this, boolean("inertia_scaled", true, "multiply the gains by the base's nominal inertia")};
  RealParameter derivative_time_{
      this, real("derivative_time", "s", 0.005, at_least(0.0),
                 "time constant of the filter of the derivative; 0: no filter")};
  RealsParameter max_rate_{this,
                           reals("max_rate", "rad/s", {10.0, 10.0, 5.0}, between(1e-6, 1000.0),
                                 "rates for action +1; commands are clamped to them")};

  SymMat3<double> inertia_{};
  int base_ = 0;
  int first_inertia_ = 0;
  double dt_ = 0.0;
  double derivative_share_ = 1.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Ctbr, "ctbr", "1.0.0",
               "Controls collective thrust [N] and body rates [rad/s].");
