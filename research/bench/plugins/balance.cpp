// Takes a command like a law and returns the output that balances the weight, level and at rest: a
// law without computation, so that a benchmark can subtract the rest of a step.
#include <vector>

#include "controllers/common/trajectory.h"

namespace skybody {
namespace {

class Balance : public Controller {
 public:
  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    const double weight = control::total_mass(setup, robot) * control::gravity_of(setup);
    const std::string& word = gives_.value();
    if (word == "ctbt" || word == "ctbr") {
      given_ = {weight, 0.0, 0.0, 0.0};
    } else if (word == "rotor_speed") {
      const View<RotorInfo> rotors = control::working_rotors(setup, robot, "balance");
      for (const RotorInfo& rotor : rotors) {
        given_.push_back(
            sqrt(weight / rotors.size() / rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT]));
      }
    } else {
      given_ = {weight, 1.0, 0.0, 0.0, 0.0};
      if (word == "attitude_with_rates") given_.insert(given_.end(), {0.0, 0.0, 0.0});
    }
    if (takes_.value() == "trajectory") {
      control::declare_trajectory(setup, 1, {{-5.0, -5.0, 0.5}, {5.0, 5.0, 3.0}});
    } else {
      setup.input(Signal::kForce, {-1.0, -1.0, 0.0, -1.0}, {1.0, 1.0, 1.0, 1.0});
    }
    setup.output(word == "ctbt"          ? Signal::kCtbt
                 : word == "ctbr"        ? Signal::kCtbr
                 : word == "rotor_speed" ? Signal::kRotorSpeed
                                         : Signal::kAttitude,
                 static_cast<int>(given_.size()));
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real> output) const {
    for (std::size_t k = 0; k < given_.size(); ++k) {
      output.set(static_cast<int>(k), Real(given_[k]));
    }
  }

 private:
  TextParameter takes_{
      this, choice("takes", "trajectory", {"trajectory", "force"}, "signal of the input")};
  TextParameter gives_{
      this,
      choice("gives", "ctbt", {"ctbt", "ctbr", "attitude", "attitude_with_rates", "rotor_speed"},
             "signal of the output")};

  std::vector<double> given_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Balance, "balance", "1.0.0",
               "Balances the weight: a law that costs nothing.");
