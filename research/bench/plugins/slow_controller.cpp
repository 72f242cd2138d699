// Passes rotor speeds on; in one chosen environment it is slow, for a benchmark of batches with a
// slow environment. Not for flying: it wastes computations, or sleeps.
#include <skybody/plugin.h>

#include <ctime>
#include <vector>

namespace skybody {
namespace {

class SlowController : public Controller {
 public:
  void configure(const Setup& setup) override {
    rotors_ = setup.rotors_of(setup.robot()).size();
    const std::vector<double> low(static_cast<std::size_t>(rotors_), 0.0);
    const std::vector<double> high(static_cast<std::size_t>(rotors_), 1.0);
    setup.input(Signal::kRotorSpeed, low, high);
    setup.output(Signal::kRotorSpeed, rotors_);
  }

  void control(const EnvView<double>& env, State<double>&, ConstValues<double> input,
               Values<double> output) const {
    const bool slow = env_.value() < 0.0 || static_cast<double>(env.stream_env()) == env_.value();
    for (int i = 0; i < rotors_; ++i) output.set(i, input[i] + (slow ? delay() : 0.0));
  }

 private:
  /// @returns 0, after a delay
  double delay() const {
    if (sleep_.value() > 0.0) {
      const timespec time{0, static_cast<long>(sleep_.value() * 1e9 / rotors_)};
      nanosleep(&time, nullptr);
    }
    double x = 1.0;
    const auto turns = static_cast<long>(turns_.value() / rotors_);
    for (long k = 0; k < turns; ++k) x = 1.0 / (1.0 + x);  // a chain: one division after another
    return x > 2.0 ? x : 0.0;
  }

  RealParameter env_{this, real("env", "", 0.0, kAny, "the slow environment's number; -1: all")};
  RealParameter turns_{this, real("turns", "", 0.0, at_least(0.0), "divisions a physics step")};
  RealParameter sleep_{this, real("sleep", "s", 0.0, at_least(0.0), "sleep a physics step")};
  int rotors_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::SlowController, "slow_controller", "1.0.0",
               "Rotor speeds passed on, slowly in one environment (benchmarks only).");
