// Rotor speed commands, clamped to each rotor's limits.
#include <vector>

#include "controllers/common/robot.h"

namespace skybody {
namespace {

class RotorSpeed : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const View<RotorInfo> rotors = control::working_rotors(setup, setup.robot(), "rotor_speed");
    std::vector<double> low, high;
    for (const RotorInfo& rotor : rotors) {
      limit_.push_back({rotor.min_speed, rotor.constants[SKYBODY_ROTOR_MAX_SPEED]});
      low.push_back(min_speed_.is_given() ? min_speed_.value() : limit_.back().low);
      high.push_back(max_speed_.value() > 0.0 ? max_speed_.value() : limit_.back().high);
      control::require_reachable("min_speed", low.back(), limit_.back().low, rotor);
      control::require_order("min_speed", low.back(), "max_speed", high.back());
    }
    setup.input(Signal::kRotorSpeed, low, high);
    setup.output(Signal::kRotorSpeed, rotors.size());
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (int i = 0; i < static_cast<int>(limit_.size()); ++i) {
      const Limit& limit = limit_[static_cast<std::size_t>(i)];
      output.set(i, clamp(input[i], Real(limit.low), Real(limit.high)));
    }
  }

 private:
  struct Limit {
    double low, high;  ///< [rad/s]
  };

  RealParameter min_speed_{this, real("min_speed", "rad/s", 0.0, kAny,
                                      "speed for action -1; not given: each rotor's own least "
                                      "speed, which is 0 unless reversible")};
  RealParameter max_speed_{this, real("max_speed", "rad/s", 0.0, at_least(0.0),
                                      "speed for action +1; 0: each rotor's own maximum")};

  std::vector<Limit> limit_;  ///< one per rotor
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::RotorSpeed, "rotor_speed", "1.0.0",
               "Sets a speed reference per rotor [rad/s] (the paper's RPM mode).");
