// Ends the process with status 0 while an environment steps.
#include <skybody/plugin.h>
#include <stdlib.h>
#include <unistd.h>

namespace {

using namespace skybody;

class ExitsInAStep : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, std::vector<double>(4, 0.0), std::vector<double>(4, 1000.0));
    setup.output(Signal::kRotorSpeed, 4);
  }
  void control(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {
    if (by_.value() == "exit") exit(0);
    if (by_.value() == "quick_exit") quick_exit(0);
    if (by_.value() == "_Exit") _Exit(0);
    _exit(0);
  }

 private:
  TextParameter by_{this, {.name = "by", .value = "exit", .doc = "the function that it calls"}};
};

}  // namespace

SKYBODY_PLUGIN(ExitsInAStep, "exits_in_a_step", "1.0.0",
               "Ends the process, as if all were well, while an environment steps.");
