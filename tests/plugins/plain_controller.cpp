// The controller of lane_controller.cpp for plain double, with a plain `if`; it runs lane by lane.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class PlainController : public Controller {
 public:
  struct State {
    Vec3<double> filtered;
    double fourth;
    std::uint64_t calls;
  };

  void configure(const Setup& setup) override {
    share_ = -expm1(-setup.dt() / tau_.value());
    setup.input(Signal::kRotorSpeed, std::vector<double>(4, 0.0), std::vector<double>(4, 1000.0));
    setup.output(Signal::kRotorSpeed, 4);
  }

  void reset(const EnvView<double>& env, State& state) const {
    const double start = env.rotor_speed(0);
    state.filtered = {start, start, start};
    state.fourth = start;
  }

  void control(const EnvView<double>& env, State& state, ConstValues<double> input,
               Values<double> output) const {
    const double gain = gain_(env);
    state.filtered += (input.vec3(0) * gain - state.filtered) * share_;
    state.fourth += (input[3] * gain - state.fourth) * share_;
    state.calls += 1;
    output.set(0, state.filtered);
    if (state.fourth > limit_.value()) {
      output.set(3, limit_.value());
    } else {
      output.set(3, max(state.fourth, 0.0));
    }
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

SKYBODY_PLUGIN(PlainController, "plain_controller", "1.0.0", "Filters rotor speeds, lane by lane.");
