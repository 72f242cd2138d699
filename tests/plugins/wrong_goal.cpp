// Does not compile, with a clear message: goal() is not const.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class WrongGoal : public Task {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}
  void goal(const EnvView<double>&, const State<double>&, Values<double>) {}
};

}  // namespace

SKYBODY_PLUGIN(WrongGoal, "wrong_goal", "1.0.0", "Does not compile.");
