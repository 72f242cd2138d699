// A stateful sensor with a buffer, noise, and a helper that must be inlined. Output: the height
// `delay` calls earlier.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

/// A helper outside the class, so large that g++ would rather call than inline it.
template <class Real>
Real curve(const Real& x, const Vec3<Real>& v) {
  Real sum = x;
  for (int i = 0; i < 5; ++i) sum = sum + exp(-abs(v.x)) * sin(v.y + sum) / (1.0 + square(v.z));
  return sum;
}

class DelaySensor : public Sensor {
 public:
  template <class Real>
  struct State {
    Word<Real> calls;
    Real bias;
    Real history[3];
  };

  void configure(const Setup& setup) override {
    delay_steps_ = static_cast<int>(delay_.value());
    setup.buffer(delay_steps_ + 1);
    setup.period(2);
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.channel("curve", "", 1, -kInfinity, kInfinity);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state, Values<Real> buffer) const {
    state.bias = random(env).normal(Real(0.0), Real(noise_.value()));
    const Real height = env.body(0).position.z;
    for (int i = 0; i <= delay_steps_; ++i) buffer.set(i, height);
    for (Real& h : state.history) h = height;
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>& state, Values<Real> output,
             Values<Real> buffer) const {
    for (int i = delay_steps_; i > 0; --i) buffer.set(i, buffer[i - 1]);
    buffer.set(0, env.body(0).position.z);
    auto noise = random(env, 1);
    state.calls += 1;
    state.history[2] = state.history[1];
    state.history[1] = state.history[0];
    state.history[0] = buffer[delay_steps_] + state.bias + noise_.value() * noise.normal();
    output.set(0, state.history[0]);
    output.set(1, helper(env, state) + to_real(noise.integer(10)));
  }

 private:
  template <class Real>
  Real helper(const EnvView<Real>& env, const State<Real>& state) const {
    return curve(state.history[1], env.body(0).velocity) +
           curve(state.history[2], env.body(0).angular_velocity);
  }

  IntegerParameter delay_{this,
                          {.name = "delay", .value = 3, .min = 0, .max = 100, .doc = "calls"}};
  RealParameter noise_{
      this, {.name = "noise", .unit = "m", .value = 0.01, .min = 0.0, .doc = "deviation"}};
  int delay_steps_ = 0;
};

}  // namespace

SKYBODY_PLUGIN(DelaySensor, "delay_sensor", "1.0.0", "Height, some calls late, with noise.");
