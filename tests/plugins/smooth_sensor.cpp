// Does not compile, with a clear message: sensors have no functions on dual numbers.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class SmoothSensor : public Sensor {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup&) override {}
  template <class Real>
  void sense(const EnvView<Real>&, State<Real>&, Values<Real> output) const {
    output.set(0, Real(1.0));
  }
};

}  // namespace

SKYBODY_PLUGIN(SmoothSensor, "smooth_sensor", "1.0.0", "Does not compile.");
