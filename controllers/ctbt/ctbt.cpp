// Collective thrust and body torque, through the rotors or directly on the body.
#include "controllers/common/thrust_torque.h"

namespace skybody {
namespace {

class Ctbt : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  using State = control::ThrustTorqueState<Real>;

  void configure(const Setup& setup) override {
    actuators_.configure(setup, setup.robot(), "ctbt", true, max_torque_.vec3());
    const control::ThrustTorqueLimits& l = actuators_.limits();
    setup.input(Signal::kCtbt, {0.0, -l.torque.x, -l.torque.y, -l.torque.z},
                {l.thrust, l.torque.x, l.torque.y, l.torque.z});
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    actuators_.reset(env, state);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
               Values<Real> output) const {
    actuators_.drive(env, state, input[0], input.vec3(1), output);
  }

 private:
  control::ThrustTorque actuators_{this};
  RealsParameter max_torque_{this, reals("max_torque", "N m", {0.0, 0.0, 0.0}, at_least(0.0),
                                         "torques for action +1; 0: the rotors' largest torques")};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Ctbt, "ctbt", "1.0.0",
               "Applies collective thrust [N] and body torque [N m].");
