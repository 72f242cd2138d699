// Does not compile, with a clear message: a plain `if` in lane code (ctest
// branch_on_lanes_is_refused).
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class BranchOnLanes : public Controller {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    if (input[0] > 1.0) {
      output.set(0, Real(1.0));
    }
  }
};

}  // namespace

SKYBODY_PLUGIN(BranchOnLanes, "branch_on_lanes", "1.0.0", "Does not compile.");
