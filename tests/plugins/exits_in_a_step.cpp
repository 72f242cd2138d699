// Ends the process, as if all were well, while an environment steps.
#include <skybody/plugin.h>
#include <stdlib.h>

namespace {

using namespace skybody;

class ExitsInAStep : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, std::vector<double>(4, 0.0), std::vector<double>(4, 1000.0));
    setup.output(Signal::kRotorSpeed, 4);
  }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {
    exit(0);
  }
};

}  // namespace

SKYBODY_PLUGIN(ExitsInAStep, "exits_in_a_step", "1.0.0",
               "Ends the process, as if all were well, while an environment steps.");
