// Magnetometer: the world's magnetic field in the sensor's axes, with hard and soft iron.
#include "sensors/common/errors.h"
#include "sensors/common/mount.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class Magnetometer : public sensor::TimedSensor {
 public:
  Magnetometer()
      : TimedSensor({.steps = 0,
                     .rate = 100.0,
                     .doc = "interval of samples; 0: 100 Hz, to the nearest physics step"}) {}

  void configure(const Setup& setup) override {
    mount_.configure(setup);
    configure_timing(setup, {.size = 3, .has_stamp = true, .may_leave_out = true});
    setup.channel("field", "uT", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("stamp", "s", 1, 0.0, kInfinity, mount_.robot());
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> sample = room(env, output);
    if (any(is_due)) sample.set(0, measured(env));
    deliver(env, is_due, sample, output, buffer);
  }

 private:
  template <class Real>
  SKYBODY_INLINE Vec3<Real> measured(const EnvView<Real>& env) const {
    const Quat<Real> axes = env.body(mount_.body()).rotation * mount_.rotation(env);
    Vec3<Real> field = rotate_inverse(axes, field_.vec3(env));
    if (soft_iron_.is_given()) field = bent(env, field);
    if (hard_iron_.is_given()) field += hard_iron_.vec3(env);
    if (noise_.is_given()) {
      Real draws[4];
      sensor::fill_normal(random(env), draws);
      field = sensor::with_noise(field, noise_(env), sensor::vec3_of(draws, 0));
    }
    if (!resolution_.is_given() && !range_.is_given()) return field;
    const auto read = [&](const Real& x) {
      return sensor::saturated(sensor::quantized(x, resolution_(env)), range_(env));
    };
    return {read(field.x), read(field.y), read(field.z)};
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> bent(const EnvView<Real>& env, const Vec3<Real>& v) const {
    const auto row = [&](int i) {
      return Vec3<Real>{soft_iron_(env, i), soft_iron_(env, i + 1), soft_iron_(env, i + 2)};
    };
    return {dot(row(0), v), dot(row(3), v), dot(row(6), v)};
  }

  sensor::Mount mount_{this};
  RealsParameter field_{this,
                        when_given(reals("field", "uT", {20.0, 0.0, -44.0}, kAny,
                                         "magnetic field, W axes; by default north is along x"))};
  RealsParameter hard_iron_{this,
                            when_given(reals("hard_iron", "uT", {0.0, 0.0, 0.0}, kAny,
                                             "field of the vehicle's own magnets, sensor axes"))};
  RealsParameter soft_iron_{
      this, when_given(reals("soft_iron", "", {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, kAny,
                             "matrix on the field in sensor axes, row by row"))};
  RealParameter noise_{
      this, sensor::error_size("noise", "uT", "standard deviation of each reading, per axis")};
  RealParameter resolution_{
      this,
      sensor::error_size("resolution", "uT", "readings are multiples of this; 0: not rounded")};
  RealParameter range_{
      this, sensor::error_size("range", "uT", "greatest magnitude of a reading; 0: no limit")};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Magnetometer, "magnetometer", "1.0.0",
               "Magnetic field [uT] in the sensor's axes, with hard and soft iron.");
