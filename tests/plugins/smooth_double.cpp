// Does not compile, with a clear message: a smooth controller whose step method takes double.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class SmoothDouble : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup&) override {}
  void control(const EnvView<double>&, State<double>&, ConstValues<double> input,
               Values<double> output) const {
    output.set(0, input[0]);
  }
};

}  // namespace

SKYBODY_PLUGIN(SmoothDouble, "smooth_double", "1.0.0", "Does not compile.");
