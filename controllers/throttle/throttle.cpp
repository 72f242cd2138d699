// Throttles: each rotor's speed reference as a share of its maximum speed.
#include <vector>

#include "controllers/common/robot.h"

namespace skybody {
namespace {

class Throttle : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const View<RotorInfo> rotors = control::working_rotors(setup, setup.robot(), "throttle");
    for (const RotorInfo& rotor : rotors) {
      max_speed_.push_back(rotor.first_param + SKYBODY_ROTOR_MAX_SPEED);
    }
    control::require_order("min_throttle", min_.value(), "max_throttle", max_.value());
    const std::vector<double> low(max_speed_.size(), min_.value());
    const std::vector<double> high(max_speed_.size(), max_.value());
    setup.input(Signal::kThrottle, low, high);
    setup.output(Signal::kRotorSpeed, rotors.size());
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (int i = 0; i < static_cast<int>(max_speed_.size()); ++i) {
      const Real throttle = clamp(input[i], Real(0.0), Real(1.0));
      output.set(i, throttle * env.param(max_speed_[static_cast<std::size_t>(i)]));
    }
  }

 private:
  RealParameter min_{this,
                     real("min_throttle", "", 0.0, between(0.0, 1.0), "throttle for action -1")};
  RealParameter max_{this,
                     real("max_throttle", "", 1.0, between(0.0, 1.0), "throttle for action +1")};

  std::vector<int> max_speed_;  ///< EnvParams, one per rotor
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Throttle, "throttle", "1.0.0",
               "Sets a speed reference per rotor as a share of its own largest speed.");
