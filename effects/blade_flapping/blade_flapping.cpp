// Aerodynamics at rotor hubs: axial drag, the moment of flapping blades, translational lift.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/rotors.h"

namespace skybody {
namespace {

class BladeFlapping : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    for (const int r :
         effect::robots_with_one_way_rotors(setup, robots_.values(), "the effect blade_flapping")) {
      const RobotInfo& robot = setup.robots()[r];
      for (int i = 0; i < robot.rotor_count; ++i) rotors_.push_back(robot.first_rotor + i);
    }
    setup.holds(HeldInput::kRotorFlow);
    setup.steady();
  }

  /// Sets the coefficients; the engine evaluates the forces at every stage of the integrator.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Real axial = axial_drag_(env), flapping = flapping_(env), lift = lift_(env);
    for (const int rotor : rotors_) held.add_rotor_flow(rotor, axial, flapping, lift);
  }

 private:
  TextsParameter robots_{
      this, words("robots", "robots whose rotors are affected; empty: all with rotors")};
  RealParameter axial_drag_{
      this, randomizable(real("axial_drag", "N s^2/(m rad)", 0.0, between(0.0, 1.0),
                              "axial drag force per rotor speed and axial hub velocity"))};
  RealParameter flapping_{
      this, randomizable(real("flapping", "N s^2/rad", 0.0, between(0.0, 1.0),
                              "moment per rotor speed and hub velocity across the axis"))};
  RealParameter lift_{
      this, randomizable(real("translational_lift", "N s^2/m^2", 0.0, between(0.0, 1000.0),
                              "added thrust per squared air speed across the axis"))};

  std::vector<int> rotors_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(
    skybody::BladeFlapping, "blade_flapping", "1.0.0",
    "Axial drag, flapping moment and translational lift of rotors that move through the air.");
