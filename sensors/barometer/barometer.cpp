// Barometer: static pressure of the standard atmosphere, and the altitude that it stands for.
#include "sensors/common/atmosphere.h"
#include "sensors/common/errors.h"
#include "sensors/common/mount.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class Barometer : public sensor::TimedSensor {
 public:
  Barometer()
      : TimedSensor({.steps = 0,
                     .rate = 50.0,
                     .doc = "interval of samples; 0: 50 Hz, to the nearest physics step"}) {}

  void configure(const Setup& setup) override {
    mount_.configure(setup);
    configure_timing(setup, {.size = 2,
                             .own_words = drift_.is_given() ? 1 : 0,
                             .has_stamp = true,
                             .may_leave_out = !drift_.is_given()});
    setup.channel("pressure", "Pa", 1, 0.0, kInfinity, mount_.robot());
    setup.channel("altitude", "m", 1, -kInfinity, kInfinity, mount_.robot());
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
  template <class Real>
  SKYBODY_INLINE void measure(const EnvView<Real>& env, const MaskOf<Real>& due,
                              const Values<Real>& sample, const Values<Real>& buffer) const {
    const Real height = mount_.position(env, env.body(mount_.body())).z;
    Real pressure = sea_level_pressure_(env) *
                    sensor::pressure_ratio(altitude_(env) + height, temperature_(env));
    if (noise_.is_given() || drift_.is_given()) {
      Real draws[2];
      sensor::fill_normal(random(env), draws);
      pressure = sensor::with_noise(pressure, noise_(env), draws[0]);
      if (drift_.is_given()) {
        pressure += sensor::wandered(env, due, drift_(env), drift_time_(env), interval(), draws[1],
                                     buffer, 0);
      }
    }
    if (resolution_.is_given()) pressure = sensor::quantized(pressure, resolution_(env));
    sample.set(0, pressure);
    sample.set(1, sensor::pressure_altitude(pressure));
  }

  sensor::Mount mount_{this};
  RealParameter altitude_{this, when_given(real("altitude", "m", 0.0, between(-500.0, 10000.0),
                                                "altitude of W's origin above the sea"))};
  RealParameter sea_level_pressure_{
      this, when_given(real("sea_level_pressure", "Pa", sensor::kSeaLevelPressure,
                            between(80000.0, 120000.0), "pressure at sea level"))};
  RealParameter temperature_{
      this, when_given(real("temperature", "K", sensor::kSeaLevelTemperature, between(200.0, 350.0),
                            "temperature at sea level"))};
  RealParameter noise_{this,
                       sensor::error_size("noise", "Pa", "standard deviation of each reading")};
  RealParameter drift_{this, sensor::error_size("drift", "Pa",
                                                "standard deviation of an error that wanders "
                                                "within `drift_time`")};
  RealParameter drift_time_{this, when_given(real("drift_time", "s", 100.0, at_least(1e-3),
                                                  "correlation time of the drift"))};
  RealParameter resolution_{
      this,
      sensor::error_size("resolution", "Pa", "readings are multiples of this; 0: not rounded")};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Barometer, "barometer", "1.0.0",
               "Static pressure [Pa] of the standard atmosphere, and its altitude [m].");
