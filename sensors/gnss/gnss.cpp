// Satellite navigation: position and velocity with noise and a wandering bias.
#include "sensors/common/errors.h"
#include "sensors/common/mount.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class Gnss : public sensor::TimedSensor {
 public:
  Gnss()
      : TimedSensor({.steps = 0,
                     .rate = 10.0,
                     .doc = "interval of fixes; 0: 10 Hz, to the nearest physics step"}) {}

  void configure(const Setup& setup) override {
    mount_.configure(setup);
    has_bias_ = horizontal_bias_.is_given() || vertical_bias_.is_given();
    configure_timing(setup, {.size = 6,
                             .own_words = has_bias_ ? 3 : 0,
                             .has_stamp = true,
                             .may_leave_out = !has_bias_});
    setup.channel("position", "m", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("stamp", "s", 1, 0.0, kInfinity, mount_.robot());
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> sample = room(env, output);
    if (any(is_due)) measure(env, is_due, sample, buffer);
    deliver(env, is_due, sample, output, buffer);
  }

 private:
  static constexpr std::uint64_t kNoiseDraws = 0, kBiasDraws = 1;

  template <class Real>
  SKYBODY_INLINE void measure(const EnvView<Real>& env, const MaskOf<Real>& due,
                              const Values<Real>& sample, const Values<Real>& buffer) const {
    const BodyMotion<Real> body = env.body(mount_.body());
    Vec3<Real> position = mount_.position(env, body), velocity = mount_.velocity(env, body);
    if (horizontal_noise_.is_given() || vertical_noise_.is_given() || velocity_noise_.is_given()) {
      Real draws[6];
      sensor::fill_normal(random(env, kNoiseDraws), draws);
      position = with_noise(position, horizontal_noise_(env), vertical_noise_(env), draws);
      velocity = sensor::with_noise(velocity, velocity_noise_(env), sensor::vec3_of(draws, 3));
    }
    if (has_bias_) position += bias(env, due, buffer);
    sample.set(0, position);
    sample.set(3, velocity);
  }

  template <class Real, int N>
  static SKYBODY_INLINE Vec3<Real> with_noise(const Vec3<Real>& value, const Real& horizontal,
                                              const Real& vertical, const Real (&draws)[N]) {
    return {sensor::with_noise(value.x, horizontal, draws[0]),
            sensor::with_noise(value.y, horizontal, draws[1]),
            sensor::with_noise(value.z, vertical, draws[2])};
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> bias(const EnvView<Real>& env, const MaskOf<Real>& due,
                                 const Values<Real>& buffer) const {
    Real draws[4];
    sensor::fill_normal(random(env, kBiasDraws), draws);
    const auto wandered = [&](int i, const RealParameter& deviation) {
      return sensor::wandered(env, due, deviation(env), bias_time_(env), interval(), draws[i],
                              buffer, i);
    };
    return {wandered(0, horizontal_bias_), wandered(1, horizontal_bias_),
            wandered(2, vertical_bias_)};
  }

  sensor::Mount mount_{this};
  RealParameter horizontal_noise_{
      this, sensor::error_size("horizontal_noise", "m", "standard deviation along x and y of W")};
  RealParameter vertical_noise_{
      this, sensor::error_size("vertical_noise", "m", "standard deviation along z of W")};
  RealParameter velocity_noise_{
      this, sensor::error_size("velocity_noise", "m/s", "standard deviation per axis")};
  RealParameter horizontal_bias_{
      this, sensor::error_size("horizontal_bias", "m",
                               "standard deviation of the bias that wanders within `bias_time`")};
  RealParameter vertical_bias_{this,
                               sensor::error_size("vertical_bias", "m", "the same along z of W")};
  RealParameter bias_time_{this, when_given(real("bias_time", "s", 60.0, at_least(1e-3),
                                                 "correlation time of the bias"))};
  bool has_bias_ = false;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(
    skybody::Gnss, "gnss", "1.0.0",
    "Satellite navigation: position [m] and velocity [m/s] in W, with a wandering bias.");
