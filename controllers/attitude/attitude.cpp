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
    error_.configure();
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
    const Quat<Real> reference = control::unit_or_identity(input.quat(1));
    const Quat<Real> error = conjugate(env.body(base_).rotation) * reference;
    const Vec3<Real> turn = error_(error), gain = gain_.vec3(env);
    output.set(0, clamp(input[0], Real(0.0), Real(thrust_)));
    Vec3<Real> rate{gain.x * turn.x, gain.y * turn.y, gain.z * turn.z};
    if (takes_rates_) rate += rotate(error, input.vec3(5));
    const Vec3<Real> held = control::clamp_symmetric(rate, max_rate_.vec3());
    output.set(1, held);
    report_.note(control::differs(held, rate), buffer);
  }

 private:
  RealsParameter gain_{this, randomizable(reals("gain", "1/s", {8.0, 8.0, 3.0}, at_least(0.0),
                                                "rate per angle of error, base axes"))};
  RealsParameter max_rate_{this, reals("max_rate", "rad/s", {10.0, 10.0, 5.0}, at_least(1e-6),
                                       "limits of the commanded rates")};
  RealParameter max_thrust_{this, real("max_thrust", "N", 0.0, at_least(0.0),
                                       "thrust for action +1; 0: all rotors' full thrust")};
  control::AttitudeErrorChoice error_{this};
  BooleanParameter feed_forward_{
      this, boolean("feed_forward", false, "also read the desired attitude's rates, and add them")};

  control::LimitReport report_;
  bool takes_rates_ = false;
  int base_ = 0;
  double thrust_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Attitude, "attitude", "1.0.0",
               "Controls collective thrust [N] and attitude; output: ctbr.");
