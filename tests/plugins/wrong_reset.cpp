// Does not compile, with a clear message: reset() lacks the state.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class WrongReset : public Task {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}
  template <class Real>
  void reset(const EnvView<Real>&) const {}
};

}  // namespace

SKYBODY_PLUGIN(WrongReset, "wrong_reset", "1.0.0", "Does not compile.");
