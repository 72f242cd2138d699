// A lane controller with state, parameters (one randomizable) and a reset: a typical plugin source.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

/// Low-pass filter in front of the rotors: y += (1 - exp(-dt / tau)) (gain u - y).
class LaneController : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Vec3<Real> filtered;
    Real fourth;
    Word<Real> calls;
  };

  void configure(const Setup& setup) override {
    share_ = -expm1(-setup.dt() / tau_.value());
    setup.input(Signal::kRotorSpeed, std::vector<double>(4, 0.0), std::vector<double>(4, 1000.0));
    setup.output(Signal::kRotorSpeed, 4);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    const Real start = env.rotor_speed(0);
    state.filtered = {start, start, start};
    state.fourth = start;
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
               Values<Real> output) const {
    const Real gain = gain_(env);
    state.filtered += (input.vec3(0) * gain - state.filtered) * Real(share_);
    state.fourth += (input[3] * gain - state.fourth) * share_;
    state.calls += 1;
    output.set(0, state.filtered);
    const Real limited = clamp(state.fourth, 0.0, limit_.value());
    output.set(3, select(env.served(), limited, Real(0.0)));
  }

 private:
  RealParameter tau_{this,
                     {.name = "tau",
                      .unit = "s",
                      .value = 0.02,
                      .min = 1e-6,
                      .max = 10.0,
                      .doc = "time constant"}};
  RealParameter gain_{
      this,
      {.name = "gain", .value = 1.0, .min = 0.0, .max = 2.0, .doc = "gain", .randomizable = true}};
  RealParameter limit_{this,
                       {.name = "limit",
                        .unit = "rad/s",
                        .value = 900.0,
                        .min = 0.0,
                        .doc = "upper limit of the fourth output"}};
  double share_ = 0.0;
};

}  // namespace

SKYBODY_PLUGIN(LaneController, "lane_controller", "1.0.0", "Filters rotor speeds in lanes.");
