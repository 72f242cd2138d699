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
    control::ThrustTorqueChoice choice;
    choice.rotors = apply_.value() == "rotors";
    choice.time_up = time_up_.value();
    choice.time_down = time_down_.value();
    choice.max_thrust = max_thrust_.value();
    choice.max_torque = max_torque_.vec3();
    actuators_.configure(setup, setup.robot(), "ctbt", choice, allocation_);
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
  TextParameter apply_{
      this,
      {.name = "apply",
       .value = "rotors",
       .choices = {"rotors", "body"},
       .doc = "rotors: by allocation; body: lagged wrench on the body (eq. 1 and 2)"}};
  RealParameter time_up_{
      this,
      {.name = "time_constant_up",
       .unit = "s",
       .value = -1.0,
       .min = -1.0,
       .doc = "body: time constant of the lag while a channel grows; below 0: the rotors' mean"}};
  RealParameter time_down_{
      this,
      {.name = "time_constant_down",
       .unit = "s",
       .value = -1.0,
       .min = -1.0,
       .doc = "body: time constant of the lag while a channel shrinks; below 0: the rotors' mean"}};
  RealParameter max_thrust_{this,
                            {.name = "max_thrust",
                             .unit = "N",
                             .value = 0.0,
                             .min = 0.0,
                             .doc = "thrust for action +1; 0: all rotors' full thrust"}};
  RealsParameter max_torque_{this,
                             {.name = "max_torque",
                              .unit = "N m",
                              .values = {0.0, 0.0, 0.0},
                              .min = 0.0,
                              .doc = "torques for action +1; 0: the rotors' largest torques"}};
  control::AllocationChoice allocation_{this};

  control::ThrustTorque actuators_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Ctbt, "ctbt", "1.0.0",
               "Applies collective thrust [N] and body torque [N m].");
