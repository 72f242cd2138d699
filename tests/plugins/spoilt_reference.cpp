// Passes a trajectory on, but from a given step sets its value `value` to NaN in one environment.
// Tests the response of control laws.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class SpoiltReference : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    setup.input(Signal::kTrajectory, kReferencePointSize);
    setup.output(Signal::kTrajectory, kReferencePointSize);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (int k = 0; k < kReferencePointSize; ++k) output.set(k, input[k]);
    const auto is_meant = env.stream_env() == Word<Real>(static_cast<std::uint64_t>(env_.value()));
    const auto is_late = env.physics_step() > Word<Real>(static_cast<std::uint64_t>(step_.value()));
    const int k = static_cast<int>(value_.value());
    output.set(k, select(logical_and(is_meant, is_late), Real(kNan), output[k]));
  }

 private:
  IntegerParameter env_{this, {.name = "env", .value = 0, .min = 0, .doc = "which environment"}};
  IntegerParameter step_{
      this, {.name = "step", .value = 20, .min = 0, .doc = "physics steps before it is spoilt"}};
  IntegerParameter value_{this,
                          {.name = "value", .value = 0, .min = 0, .max = 16, .doc = "which value"}};
};

}  // namespace

SKYBODY_PLUGIN(SpoiltReference, "spoilt_reference", "1.0.0", "A reference that breaks");
