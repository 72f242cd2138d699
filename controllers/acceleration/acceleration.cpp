// Acceleration controller: a desired acceleration in world axes and a heading to a force. Chain
// `force` next.
#include "controllers/common/guidance.h"

namespace skybody {
namespace {

class Acceleration : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    mass_ = control::total_mass(setup, setup.robot());
    limits_.configure(setup);
    const double side = limits_.side();
    setup.input(Signal::kAcceleration, {-side, -side, -limits_.down(), -kPi},
                {side, side, limits_.up(), kPi});
    setup.output(Signal::kForce, 4);
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    output.set(0, limits_.thrust(input.vec3(0), buffer) * Real(mass_));
    output.set(3, input[3]);
  }

 private:
  control::ReportedLimits limits_{this, control::kTrajectoryLimits};

  double mass_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Acceleration, "acceleration", "1.0.0",
               "Controls acceleration in world axes [m/s^2] and yaw [rad]; output: force.");
