// Attitude controller: body rates proportional to the attitude error, plus feed-forward of the
// desired attitude's rates. Chain `ctbr` next.
#include <vector>

#include "controllers/common/allocation.h"
#include "controllers/common/attitude_error.h"
#include "controllers/common/limit_report.h"

namespace skybody {
namespace {

class Attitude : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    thrust_ = max_thrust_.value();
    if (!(thrust_ > 0.0)) {
      thrust_ = control::limits_of(control::working_rotors(setup, robot, "attitude"),
                                   setup.bodies()[base_])
                    .thrust;
    }
    error_ = control::attitude_error_of(error_word_.value());
    takes_rates_ = feed_forward_.value();
    std::vector<double> low = {0.0, -1.0, -1.0, -1.0, -1.0}, high = {thrust_, 1.0, 1.0, 1.0, 1.0};
    if (takes_rates_) {
      const Vec3<double> rate = max_rate_.vec3();
      low.insert(low.end(), {-rate.x, -rate.y, -rate.z});
      high.insert(high.end(), {rate.x, rate.y, rate.z});
    }
    setup.input(Signal::kAttitude, low, high);
    setup.output(Signal::kCtbr, 4);
    report_.configure(setup, 0);
    setup.buffer(1);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const Quat<Real> setpoint = input.quat(1);
    const Real size = squared_norm(setpoint);
    const auto usable = size > 1e-12;
    const Real scale = 1.0 / sqrt(select(usable, size, Real(1.0)));
    const Quat<Real> unit{setpoint.w * scale, setpoint.x * scale, setpoint.y * scale,
                          setpoint.z * scale};
    const Quat<Real> reference = select(usable, unit, Quat<Real>::identity());
    const Quat<Real> error = conjugate(env.body(base_).rotation) * reference;
    const Vec3<Real> turn = control::attitude_error(error_, error), gain = gain_.vec3(env);
    output.set(0, clamp(input[0], Real(0.0), Real(thrust_)));
    Vec3<Real> rate{gain.x * turn.x, gain.y * turn.y, gain.z * turn.z};
    if (takes_rates_) rate += rotate(error, input.vec3(5));
    const Vec3<Real> held = control::clamp_symmetric(rate, max_rate_.vec3());
    output.set(1, held);
    report_.note(control::differs(held, rate), buffer);
  }

 private:
  RealsParameter gain_{this,
                       {.name = "gain",
                        .unit = "1/s",
                        .values = {8.0, 8.0, 3.0},
                        .min = 0.0,
                        .doc = "rate per angle of error, base axes",
                        .randomizable = true}};
  RealsParameter max_rate_{this,
                           {.name = "max_rate",
                            .unit = "rad/s",
                            .values = {10.0, 10.0, 5.0},
                            .min = 1e-6,
                            .doc = "limits of the commanded rates"}};
  RealParameter max_thrust_{this,
                            {.name = "max_thrust",
                             .unit = "N",
                             .value = 0.0,
                             .min = 0.0,
                             .doc = "thrust for action +1; 0: all rotors' full thrust"}};
  TextParameter error_word_{this,
                            {.name = "error",
                             .value = "quaternion",
                             .choices = {"quaternion", "tilt_priority", "se3"},
                             .doc = "form of the attitude error"}};
  BooleanParameter feed_forward_{this,
                                 {.name = "feed_forward",
                                  .value = false,
                                  .doc = "also read the desired attitude's rates, and add them"}};

  control::LimitReport report_;
  control::AttitudeError error_ = control::AttitudeError::kQuaternion;
  bool takes_rates_ = false;
  int base_ = 0;
  double thrust_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Attitude, "attitude", "1.0.0",
               "Controls collective thrust [N] and attitude; output: ctbr.");
