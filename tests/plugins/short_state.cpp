// Does not compile, with a clear message: a State member is not a 64-bit word.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class ShortState : public Controller {
 public:
  template <class Real>
  struct State {
    Real filtered;
    int calls;
  };
  void configure(const Setup&) override {}
  template <class Real>
  void control(const EnvView<Real>&, State<Real>& state, ConstValues<Real>, Values<Real>) const {
    ++state.calls;
  }
};

}  // namespace

SKYBODY_PLUGIN(ShortState, "short_state", "1.0.0", "Does not compile.");
