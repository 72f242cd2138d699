// Does not compile, with a clear message: process() takes double, evaluate() takes any Real.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class WrongProcess : public Task {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}
  void process(const EnvView<double>&, State<double>&, ConstValues<double>, Values<double>) const {}
};

}  // namespace

SKYBODY_PLUGIN(WrongProcess, "wrong_process", "1.0.0", "Does not compile.");
