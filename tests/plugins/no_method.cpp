// Does not compile, with a clear message: control() is not const.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class NoMethod : public Controller {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) {}
};

}  // namespace

SKYBODY_PLUGIN(NoMethod, "no_method", "1.0.0", "Does not compile.");
