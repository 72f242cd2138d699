// Single rotor thrusts: each rotor's speed for its commanded thrust.
#include <vector>

#include "controllers/common/robot.h"

namespace skybody {
namespace {

class Srt : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const View<RotorInfo> rotors = control::working_rotors(setup, setup.robot(), "srt");
    std::vector<double> low, high;
    for (const RotorInfo& rotor : rotors) {
      rotors_.push_back({control::least_thrust(rotor), control::full_thrust(rotor),
                         1.0 / rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT]});
      low.push_back(min_thrust_.is_given() ? min_thrust_.value() : rotors_.back().least);
      high.push_back(max_thrust_.value() > 0.0 ? max_thrust_.value() : rotors_.back().full);
      control::require_reachable("min_thrust", low.back(), rotors_.back().least, rotor);
      control::require_order("min_thrust", low.back(), "max_thrust", high.back());
    }
    setup.input(Signal::kSrt, low, high);
    setup.output(Signal::kRotorSpeed, rotors.size());
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (int i = 0; i < static_cast<int>(rotors_.size()); ++i) {
      const Rotor& rotor = rotors_[static_cast<std::size_t>(i)];
      const Real thrust = clamp(input[i], Real(rotor.least), Real(rotor.full));
      output.set(i, control::speed_for(thrust, rotor.least, rotor.per_constant));
    }
  }

 private:
  struct Rotor {
    double least, full;   ///< [N]
    double per_constant;  ///< 1 / kf
  };

  RealParameter min_thrust_{
      this,
      real("min_thrust", "N", 0.0, kAny,
           "thrust for action -1; not given: 0, or a reversible rotor's thrust at its min_speed")};
  RealParameter max_thrust_{this, real("max_thrust", "N", 0.0, at_least(0.0),
                                       "thrust for action +1; 0: each rotor's full thrust")};

  std::vector<Rotor> rotors_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Srt, "srt", "1.0.0", "Sets a thrust per rotor [N] along its axis.");
