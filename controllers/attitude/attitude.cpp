// Collective thrust and attitude: body rates in proportion to the attitude error. Chain `ctbr`
// next.
#include "controllers/common/allocation.h"

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
    setup.input(Signal::kAttitude, {0.0, -1.0, -1.0, -1.0, -1.0}, {thrust_, 1.0, 1.0, 1.0, 1.0});
    setup.output(Signal::kCtbr, 4);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    const Quat<Real> wish = input.quat(1);
    const Real size = squared_norm(wish);
    const auto usable = size > 1e-12;
    const Real scale = 1.0 / sqrt(select(usable, size, Real(1.0)));
    const Quat<Real> unit{wish.w * scale, wish.x * scale, wish.y * scale, wish.z * scale};
    const Quat<Real> reference = select(usable, unit, Quat<Real>::identity());
    const Quat<Real> error = conjugate(env.body(base_).rotation) * reference;
    const Real twice = copysign(Real(2.0), error.w);
    const Vec3<Real> gain = gain_.vec3(env);
    output.set(0, clamp(input[0], Real(0.0), Real(thrust_)));
    const Vec3<Real> rate{gain.x * (twice * error.x), gain.y * (twice * error.y),
                          gain.z * (twice * error.z)};
    output.set(1, control::clamp_symmetric(rate, max_rate_.vec3()));
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
                            .doc = "limits of the rates that it asks for"}};
  RealParameter max_thrust_{this,
                            {.name = "max_thrust",
                             .unit = "N",
                             .value = 0.0,
                             .min = 0.0,
                             .doc = "thrust that action +1 means; 0: all rotors' full thrust"}};

  int base_ = 0;
  double thrust_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Attitude, "attitude", "1.0.0",
               "Collective thrust [N] and attitude; gives ctbr.");
